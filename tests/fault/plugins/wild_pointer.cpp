// A pointer into nowhere.
#include "good.hpp"

BROKEN(plugin.table.nodes = reinterpret_cast<const plumbline_node* const*>(16);)

// Says it has a node, and has no array.
#include "good.hpp"

BROKEN(plugin.table.nodes = nullptr;)

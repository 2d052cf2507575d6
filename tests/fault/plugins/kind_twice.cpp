// The same node twice in one plugin.
#include "good.hpp"

BROKEN(plugin.table.node_count = 2;)

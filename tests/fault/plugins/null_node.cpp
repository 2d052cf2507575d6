// The array of nodes holds a null.
#include "good.hpp"

BROKEN(plugin.nodes[0] = nullptr;)

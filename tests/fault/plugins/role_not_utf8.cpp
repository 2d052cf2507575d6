// The name of a node's role is no text.
#include "good.hpp"

BROKEN(plugin.node.role = "\xff";)

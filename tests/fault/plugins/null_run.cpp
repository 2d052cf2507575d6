// A node that cannot be run.
#include "good.hpp"

BROKEN(plugin.node.run = nullptr;)

// Says it has an input, and has no array.
#include "good.hpp"

BROKEN(plugin.node.inputs = nullptr;)

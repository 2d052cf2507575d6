// Declares itself anew, and otherwise, at every call.
#include "good.hpp"

BROKEN(static int calls = 0; if (++calls > 1) plugin.node.version = 2;)

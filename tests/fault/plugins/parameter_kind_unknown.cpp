// A kind of parameter that this ABI does not have.
#include "good.hpp"

BROKEN(plugin.param.kind = 77;)

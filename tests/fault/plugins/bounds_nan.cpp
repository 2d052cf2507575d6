// Bounds that are not numbers.
#include "good.hpp"

BROKEN(plugin.param.maximum = __builtin_nan("");)

// Bounds with nothing between them.
#include "good.hpp"

BROKEN(plugin.param.minimum = 2000;)

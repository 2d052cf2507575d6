// The array of parameters holds a null.
#include "good.hpp"

BROKEN(plugin.params[1] = nullptr;)

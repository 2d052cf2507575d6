// A type of a smaller form.
#include "good.hpp"

BROKEN(plugin.type.size = 8;)

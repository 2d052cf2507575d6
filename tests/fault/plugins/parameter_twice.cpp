// Two parameters of one name.
#include "good.hpp"

BROKEN(plugin.choice.name = "height";)

// A default that is no number.
#include "good.hpp"

BROKEN(plugin.param.default_text = "three";)

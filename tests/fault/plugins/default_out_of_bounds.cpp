// A default that the bounds forbid.
#include "good.hpp"

BROKEN(plugin.param.default_text = "2000";)

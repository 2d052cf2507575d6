// A default that is none of the choices.
#include "good.hpp"

BROKEN(plugin.choice.default_text = "triple";)

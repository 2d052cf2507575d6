// One of the choices is null.
#include "good.hpp"

BROKEN(plugin.choices[1] = nullptr;)

// A port without a name.
#include "good.hpp"

BROKEN(plugin.output.name = nullptr;)

// Has choices, and no array of them.
#include "good.hpp"

BROKEN(plugin.choice.choices = nullptr;)

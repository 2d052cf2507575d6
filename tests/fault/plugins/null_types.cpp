// Says it has a type, and has no array.
#include "good.hpp"

BROKEN(plugin.table.types = nullptr;)

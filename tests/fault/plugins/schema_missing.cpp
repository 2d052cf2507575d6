// A type without a schema.
#include "good.hpp"

BROKEN(plugin.type.schema = {nullptr, 0};)

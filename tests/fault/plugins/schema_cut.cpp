// A schema that ends too early.
#include "good.hpp"

BROKEN(plugin.type.schema.size /= 2;)

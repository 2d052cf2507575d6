// The name of one type with the schema of another.
#include "good.hpp"

BROKEN(plugin.type.name = plugin.input.type = plugin.output.type = "plumbline.Palace/1";)

// A port of a type that the plugin does not bring.
#include "good.hpp"

BROKEN(plugin.table.type_count = 0;)

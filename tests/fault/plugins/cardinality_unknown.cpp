// A cardinality that this ABI does not have.
#include "good.hpp"

BROKEN(plugin.input.cardinality = 9;)

// An output that claims to run once for each item.
#include "good.hpp"

BROKEN(plugin.output.cardinality = PLUMBLINE_EACH;)

// A table of an earlier, smaller form.
#include "good.hpp"

BROKEN(plugin.table.size -= 8;)

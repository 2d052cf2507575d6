// A port of a smaller form.
#include <cstddef>

#include "good.hpp"

BROKEN(plugin.input.size = offsetof(plumbline_port, doc);)

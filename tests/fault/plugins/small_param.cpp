// A parameter of a smaller form.
#include <cstddef>

#include "good.hpp"

BROKEN(plugin.param.size = offsetof(plumbline_param, choices);)

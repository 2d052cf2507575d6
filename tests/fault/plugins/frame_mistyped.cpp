// Binds a frame parameter that the type does not have, by a slip of the pen.
#include "good.hpp"

BROKEN(plugin.input.frames = "fraem=?F";)

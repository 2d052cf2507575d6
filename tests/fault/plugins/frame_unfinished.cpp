// Binds a frame parameter to nothing.
#include "good.hpp"

BROKEN(plugin.input.frames = "frame=";)

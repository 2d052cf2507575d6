// A port whose frames are null and not "".
#include "good.hpp"

BROKEN(plugin.input.frames = nullptr;)

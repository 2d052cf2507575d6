// The one that must be taken.
#include "good.hpp"

BROKEN()

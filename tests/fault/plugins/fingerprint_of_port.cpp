// A port compiled with another schema than the one that is brought along.
#include "good.hpp"

BROKEN(plugin.input.fingerprint = "12345678";)

// A fingerprint that its schema does not give.
#include "good.hpp"

BROKEN(plugin.type.fingerprint = plugin.input.fingerprint = plugin.output.fingerprint = "00000000";)

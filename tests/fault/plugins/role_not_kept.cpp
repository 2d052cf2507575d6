// Claims a role and has not its ports.
#include "good.hpp"

BROKEN(plugin.node.role = "registrar";)

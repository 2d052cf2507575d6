// Claims a role by the other spelling.
#include "good.hpp"

BROKEN(plugin.node.role = "pose_initializer";)

// A node of the form of ABI 1, without user_data.
#include <cstddef>

#include "good.hpp"

BROKEN(plugin.node.size = offsetof(plumbline_node, user_data);)

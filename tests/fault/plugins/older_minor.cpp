// Built for ABI 2.0, whose nodes say nothing of what they lack; to be taken. What lies behind its nodes is none of
// theirs.
#include <cstddef>

#include "good.hpp"

BROKEN(plugin.table.abi_minor = 0; plugin.node.size = offsetof(plumbline_node, lacks);
       plugin.node.lacks = reinterpret_cast<const char*>(1);)

// A node without a summary.
#include "good.hpp"

BROKEN(plugin.node.summary = nullptr;)

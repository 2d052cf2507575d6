// A kind that no pipeline can write.
#include "good.hpp"

BROKEN(plugin.node.kind = "broken node";)

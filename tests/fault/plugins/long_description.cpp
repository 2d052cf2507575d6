// Nothing is wrong with it, but its description is longer than a pipe, and wherever it is cut it ends like a whole one.
#include <string>

#include "good.hpp"

static const std::string words(1 << 19, '\n');

BROKEN(plugin.node.summary = words.c_str();)

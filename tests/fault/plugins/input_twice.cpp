// Two inputs of one name.
#include "good.hpp"

BROKEN(plugin.inputs[1] = &plugin.input; plugin.node.input_count = 2;)

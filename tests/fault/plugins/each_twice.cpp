// Two inputs, each of which would set how often the node runs.
#include "good.hpp"

BROKEN(static plumbline_port other = plugin.input; other.name = "other";
       other.cardinality = plugin.input.cardinality = PLUMBLINE_EACH; plugin.inputs[1] = &other;
       plugin.node.input_count = 2;)

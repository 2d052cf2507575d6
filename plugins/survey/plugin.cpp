#include "adjust_node.hpp"

using plumbline::survey::AdjustNode;

PLUMBLINE_PLUGIN("survey", "0.1.0", "MIT", AdjustNode)

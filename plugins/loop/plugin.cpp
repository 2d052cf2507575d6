#include "loop/plan_node.hpp"

using namespace plumbline::loop;

PLUMBLINE_PLUGIN("loop", "0.1.0", "MIT", PlanInstallation)

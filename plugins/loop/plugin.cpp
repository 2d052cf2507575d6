#include "loop/job_nodes.hpp"
#include "loop/plan_node.hpp"
#include "loop/state_nodes.hpp"
#include "loop/vda_nodes.hpp"

using namespace plumbline::loop;

PLUMBLINE_PLUGIN("loop", "0.1.0", "MIT", PlanInstallation, ReadActuals, ReadVda5050, ReleaseState, SimulateRobots,
                 SimulateSite, UpdateState, WriteJob, WriteVda5050)

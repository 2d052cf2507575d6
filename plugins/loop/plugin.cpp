#include "loop/job_nodes.hpp"
#include "loop/plan_node.hpp"
#include "loop/round_nodes.hpp"
#include "loop/state_nodes.hpp"
#include "loop/vda_nodes.hpp"

using namespace plumbline::loop;

PLUMBLINE_PLUGIN("loop", "0.1.0", "MIT", PlanInstallation, ReadActuals, ReadReports, ReadState, ReadVda5050,
                 ReleaseState, SimulateRobots, SimulateSite, UpdateState, WriteJob, WriteVda5050)

#include "build/loop/gate_nodes.hpp"
#include "build/loop/job_nodes.hpp"
#include "build/loop/plan_node.hpp"
#include "build/loop/robot_models.hpp"
#include "build/loop/round_nodes.hpp"
#include "build/loop/state_nodes.hpp"
#include "build/loop/vda_nodes.hpp"

using namespace plumbline::loop;

PLUMBLINE_PLUGIN("loop", PLUMBLINE_BUILD_ID, "MIT", GateGuardBand, GateJoint, PlanCentred, PlanInstallation,
                 ReadActuals, ReadReports, ReadState, ReadVda5050, ReleaseState, SimulateFitters, SimulateRobots,
                 SimulateSite, UpdateState, WriteJob, WriteVda5050)

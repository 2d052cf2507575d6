// The gates of a plan decided once more by another rule, from what the plan itself says. Nothing becomes GO that the
// plan holds because something is open: not measured, of a probability that nobody can tell. A plan in doubt stays.
#pragma once

#include "artifacts/installation_plan.hpp"

namespace plumbline::loop {

/// By p_in as the plan has it: GO from `go` on, NO_GO where 1 - p_in reaches `no_go`, HOLD between. 0: as the plan has
/// it (InstallationPlan.go_probability).
void gate_by_probability(InstallationPlanT& plan, double go = 0, double no_go = 0);

/// By each length for itself, as drawings and acceptance protocols have it (JCGM 106:2012, 8.3, guarded acceptance and
/// rejection): GO where all lengths of the panel are within their limits by k u, NO_GO where one is outside by k u,
/// HOLD between. What is common to lengths is not looked at. Of a panel that hangs, joints to one that does not are no
/// part of it, as in judge_plan(). Throws std::runtime_error for k below 0.
void gate_by_guard_band(InstallationPlanT& plan, double k);

}  // namespace plumbline::loop

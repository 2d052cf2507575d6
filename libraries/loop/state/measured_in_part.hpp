// Panels of which some plates were measured and others not.
#pragma once

#include <string>
#include <vector>

#include "artifacts/installation_plan.hpp"
#include "artifacts/loop_state.hpp"

namespace plumbline::loop {

/// Panels that are to be hung, each with its brackets that were not measured while others were: "F02-P02 without
/// F02-C03-R2". Not those that hang, by a round or by plan: a panel that hangs hides plates of its own. Nor those all
/// of whose measured brackets belong to panels that miss nothing: a bracket at a mullion carries two, and that one is
/// there does not say that the other panel is begun.
std::vector<std::string> measured_in_part(const InstallationPlanT& plan, const LoopStateT& state);

}  // namespace plumbline::loop

// Items that left the design.
#pragma once

#include <string>
#include <vector>

#include "artifacts/design.hpp"
#include "artifacts/installation_plan.hpp"
#include "artifacts/loop_state.hpp"

namespace plumbline::loop {

struct GoneItems {
  std::vector<std::string> guids;  ///< of what left, sorted
  std::string missing;  ///< items that this design does not have, and that are not said to have left; in words
};

/// What the state has by GlobalId, and neither the design nor this plan. Of a storey of which less is still there than
/// is missing nothing is said to have left: a design of one floor, or of one facade, is no revision without the others.
GoneItems gone_items(const DesignT& design, const InstallationPlanT& plan, const LoopStateT& state);

}  // namespace plumbline::loop

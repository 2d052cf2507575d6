// Issues of an execution loop: what a person is to look at, and what was mended since.
#pragma once

#include "artifacts/installation_plan.hpp"
#include "artifacts/loop_state.hpp"
#include "building/ifc/bcf.hpp"

namespace plumbline::ifc {

/// A .bcf (ZIP, BCF 2.1): an open topic for each bracket or panel that is rejected, waits to be done again, may not be
/// hung as it is measured (NO_GO) or hangs and was not seen, and for control that moved; a closed one for each that was
/// rejected, done again or not to be hung and is verified now. What is to be done by hand is in the topic of its panel;
/// it has one of its own where no panel that waits says it. A topic keeps its id from round to round, its comments are
/// what the journal says of the item. Doubts of the measurement have a topic each; items without GlobalId are named in
/// one of all. The same input gives the same bytes.
std::string write_installation_bcf(const InstallationPlanT& plan, const LoopStateT& state, const BcfOptions& options);

}  // namespace plumbline::ifc

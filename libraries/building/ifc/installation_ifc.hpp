// The state of an execution loop in the IFC: what was set and hung, why, and what comes before what.
#pragma once

#include "artifacts/installation_plan.hpp"
#include "artifacts/loop_state.hpp"
#include "building/ifc/as_built_ifc.hpp"

namespace plumbline::ifc {

struct InstallationIfcOptions {
  std::string epoch;           ///< part of the GlobalIds and of the sets' names: several can stand in one file
  std::int64_t timestamp = 0;  ///< of the additions, s since 1970; 0 takes the latest date of the file
};

/// ASB_InstallationState on every bracket's and panel's element: where it stands, since when and why, what a bracket
/// was set by, where a panel hangs; and for each an IfcTask assigned to its element (IfcRelAssignsToProcess), in the
/// order that is kept (IfcRelSequence: brackets before their panel, panels before those that depend on them), all
/// under one task "Installation". Elements are found by GlobalId in `design`, which was read from `file` or from what
/// `file` is a copy of; an item without one, or whose element is not in the file, is a warning. The same input gives
/// the same bytes.
AsBuiltIfc write_installation(const step::File& file, const Design& design, const InstallationPlanT& plan,
                              const LoopStateT& state, const InstallationIfcOptions& options);

/// "PLANNED" to "STALE".
const char* label_of(ItemStatus status);

}  // namespace plumbline::ifc

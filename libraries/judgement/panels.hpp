// Deviation at panel level (section 6.5): what the anchors' deviations from the design do to the panels they hold.
#pragma once

#include <memory>
#include <vector>

#include "judgement/difference.hpp"

namespace plumbline::evaluate {

/// One entry for every panel with at least one measured anchor, in the order given. `deviations`: as-built minus design
/// (14) of the anchors, as the indices of `table` name them; `design` holds their design positions.
std::vector<std::unique_ptr<PanelAccuracyT>> panel_accuracy(const DifferenceSet& deviations,
                                                            const std::vector<AnchorEntry>& table,
                                                            const PointSet& design,
                                                            const std::vector<PanelEntry>& panels,
                                                            const Options& options);

}  // namespace plumbline::evaluate

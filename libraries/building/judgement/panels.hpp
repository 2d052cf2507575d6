// Deviation at panel level (section 6.5): what the anchors' deviations from the design do to the panels they hold.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "building/judgement/deviation.hpp"
#include "building/judgement/difference.hpp"

namespace plumbline::judgement {

/// One entry for every panel with at least one measured anchor, in the order given, without joints. `deviations`: (14)
/// of the measured anchors, as indices into `inputs.anchors`; `judged` holds the anchors' verdicts.
std::vector<std::unique_ptr<PanelDeviationT>> judge_panels(const DeviationInputs& inputs,
                                                           const judgement::DifferenceSet& deviations,
                                                           const std::vector<std::unique_ptr<AnchorDeviationT>>& judged,
                                                           const DeviationOptions& options);

/// "joint to P2 4.2 mm (limit 3 mm)", as the reason of a verdict has it; lengths in m.
std::string words_of_length(const std::string& what, double value, double limit);

}  // namespace plumbline::judgement

// The joints between neighbouring panels. Private to libraries/building/judgement.
#pragma once

#include <memory>
#include <vector>

#include "building/judgement/judged_panel.hpp"

namespace plumbline::judgement {

/// Finds the gaps between neighbours, judges how they change with the anchors, and adds each to the two panels of `out`
/// (in the order of `panels`). `basis`: the deviations of all anchors, whose covariance two panels share.
void judge_joints(const std::vector<JudgedPanel>& panels, const LengthBasis& basis, const DeviationOptions& options,
                  std::vector<std::unique_ptr<PanelDeviationT>>& out);

}  // namespace plumbline::judgement

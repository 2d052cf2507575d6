// The order in which anchors and panels are mended, the same on the page, in the summary and in the stake-out list.
#pragma once

#include <vector>

#include "artifacts/deviation.hpp"

namespace plumbline::judgement {

/// The axis that decides an anchor's verdict; null if none does.
const JudgedAxisT* deciding_axis(const AnchorDeviationT& anchor);

/// Fail, undecided, not measured, pass; then by the share of the tolerance used. Equal ones stay in their order.
std::vector<const AnchorDeviationT*> worst_first(const DeviationT& deviation);
std::vector<const PanelDeviationT*> worst_panels_first(const DeviationT& deviation);

}  // namespace plumbline::judgement

// The anchors of a facade by all campaigns of a loop: from its state into the plan, and back.
#pragma once

#include <set>

#include "artifacts/loop_state.hpp"
#include "loop/estimate/combine_campaigns.hpp"
#include "loop/fit/facade.hpp"

namespace plumbline::loop {

/// What becomes of the estimate in a round; empty if the facade does not say what campaigns share (Facade::own).
struct RoundsEstimate {
  std::unique_ptr<AnchorEstimateT> estimate;
  std::vector<std::string> words;  ///< what moved, and what is not combined and why
  /// Why this campaign is none that was measured since: places of it are those of one before to a micrometre, and which
  /// of its readings are is not known. Empty: nothing says so.
  std::string repetition;
};

/// Puts in the place of the measured deviations and their covariance those of all campaigns, the state's and this one.
/// What was reported as worked on since it was measured, failed, or was accepted by a person starts anew. An anchor
/// that this campaign did not measure stays unmeasured in the facade, and keeps its estimate. Fills Bracket::basis,
/// difference_sigma and campaigns. Above `most` anchors nothing is combined, and that is said; nor does
/// the estimate grow beyond: what this campaign did not measure leaves it then. `repeated`: anchors with readings of a
/// campaign before: unless it is that campaign once more, this one counts alone, and they keep the basis they had, as
/// they were not measured since.
RoundsEstimate combine_rounds(Facade& facade, const LoopStateT* state, const CombineOptions& options = {},
                              std::size_t most = 500, const std::set<std::string>& repeated = {});

/// Of an anchor's own measurement, to a micrometre, 16 hexadecimal digits: what is measured or designed elsewhere does
/// not change it. Empty: not measured.
std::string basis_of_bracket(const Facade& facade, std::size_t bracket);

}  // namespace plumbline::loop

// The picture of a bench: estimates with their intervals by place, one panel a group.
#pragma once

#include "show/bench/analysis.hpp"
#include "show/bench/drawing.hpp"

namespace plumbline::bench {

/// RMSE of each alternative of the group at each place. Groups beside it are held at the choice with which most of its
/// alternatives ran; the panel says which, and who is not in it.
Drawing panel(const Bench& bench, const Analysis& analysis, const Group& group);

/// All panels, below each other; of a bench without groups the one that there is.
Drawing figure(const Bench& bench, const Analysis& analysis);

}  // namespace plumbline::bench

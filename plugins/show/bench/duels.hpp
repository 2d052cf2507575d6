// Each pair of alternatives, compared on the trials that both finished, everything else held.
#pragma once

#include <set>

#include "show/bench/analysis.hpp"

namespace plumbline::bench {

/// All pairs of each group, over all places together before each place, with verdicts that hold for all of them at once
/// (Holm).
std::vector<Duel> judged_duels(const Bench& bench, const statistics::InferenceOptions& options);

/// Time of `nodes` in a cell, of all that do not judge if `all` [s]; nan if one of them was taken from the store and so
/// not timed.
double seconds_in(const Cell& cell, const std::set<std::string>& nodes, bool all);

}  // namespace plumbline::bench

// What an evaluation's own figures say against its inputs: floors that do not lie above one another, check anchors
// whose height fits and whose place does not.
#pragma once

#include <string>
#include <vector>

#include "artifacts/accuracy.hpp"

namespace plumbline::judgement {

/// Floors whose median height is clearly below that of a lower floor, and anchors of no floor (0 or less): drift and
/// transfers go by the floor numbers of the anchor table.
std::vector<std::string> floor_doubts(const AccuracyT& accuracy);

/// Check anchors that pass in height and fail in space against the survey: (9) to (11) look at heights only.
std::vector<std::string> space_doubts(const AccuracyT& accuracy);

}  // namespace plumbline::judgement

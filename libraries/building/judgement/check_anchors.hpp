// Check anchors, one by one: what a single one is off by more than its own covariance allows is mostly wrong itself, by
// its survey, its name or its plate, and says nothing of the uncertainty of the others.
#pragma once

#include <string>
#include <vector>

#include "artifacts/accuracy.hpp"

namespace plumbline::judgement {

/// Check anchors whose difference from the survey is larger than its covariance allows, at 0.1 % for all of them
/// together (Šidák 1967); none without covariances.
std::vector<const AnchorAccuracyT*> contradicting_checks(const AccuracyT& accuracy);

/// A sentence that names each, with what it is off by; none where more than a third contradict: then it is no matter of
/// single points.
std::vector<std::string> words_of_contradicting(const AccuracyT& accuracy);

/// Whether no check anchor contradicts and all together are not off by more than is stated, at 0.1 % each.
bool check_anchors_hold(const AccuracyT& accuracy);

}  // namespace plumbline::judgement

// What a surveyor is told of an adjusted network, and whether it may be used.
#pragma once

#include <string>
#include <vector>

#include "survey/network/network_model.hpp"

namespace plumbline::survey {

/// Uncontrolled and weak observations, hinge points, failing tests: what a surveyor should look at.
std::vector<Finding> examine(const NetworkModel& model, const AdjustOptions& options, const NetworkResult& result);

/// Coordinates look like those of a map and none was given: a finding at the head of the result, a warning (true) where
/// they hold the network. `scale` of all distances as the network would estimate it.
bool tell_missing_map(const NetworkModel& model, const AdjustOptions& options, const CommonEstimate& scale,
                      NetworkResult& result);

/// Whether the result may be used: `validity` and `verdict` of the result. An invalid result's cofactors are multiplied
/// with sigma0 squared, so that nobody who takes it all the same believes it. `critical` is that of removals.
void judge(const NetworkModel& model, const AdjustOptions& options, double critical, NetworkResult& result);

/// Known points that do not stand, worst first: the test of one among many, so that of a wrong one others may fail too.
std::vector<std::string> contradicting(const std::vector<KnownPoint>& known);

/// Readings that agree among themselves say nothing of where the network lies: while `points` are measured under names
/// that known points have in another spelling (MergedSurvey), so that these hold nothing, a sound result is doubtful.
void doubt_known_names(const std::vector<std::string>& points, NetworkResult& result);

}  // namespace plumbline::survey

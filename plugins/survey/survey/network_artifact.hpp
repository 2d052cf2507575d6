// Results as artifacts.
#pragma once

#include "artifacts/control_artifact.hpp"
#include "artifacts/points.hpp"
#include "artifacts/survey_network.hpp"
#include "survey/adjust/adjust_network.hpp"

namespace plumbline::survey {

/// All points, with `joint` their full covariance; components that do not exist are NaN.
PointsT to_points_artifact(const NetworkResult& result, bool joint);

/// Known points as the readings alone have them, and back; `statistics` has the defect of the free network.
PointsT to_artifact(const MeasuredControl& measured);
MeasuredControl measured_control(const PointsT& points);

/// Covariances of each point and of the differences of pairs (numbers of points), for networks without a joint one.
void add_covariances(const NetworkResult& result, const std::vector<std::pair<std::size_t, std::size_t>>& pairs,
                     SurveyNetworkT& network);

/// Points, statistics, tests, every observation, findings.
SurveyNetworkT to_network_artifact(const NetworkResult& result, const AdjustOptions& options);

}  // namespace plumbline::survey

// Results as artifacts.
#pragma once

#include "artifacts/control_artifact.hpp"
#include "artifacts/points.hpp"
#include "artifacts/survey_network.hpp"
#include "survey/adjust/adjust_network.hpp"

namespace plumbline::survey {

/// All points with full covariance; components that do not exist are NaN.
PointsT to_points_artifact(const NetworkResult& result);

/// Points, statistics, tests, every observation, findings.
SurveyNetworkT to_network_artifact(const NetworkResult& result, const AdjustOptions& options);

}  // namespace plumbline::survey

// Results as artifacts.
#pragma once

#include "artifacts/points.hpp"
#include "artifacts/survey_network.hpp"
#include "survey/adjust/adjust_network.hpp"

namespace plumbline::survey {

/// All points with full covariance; components that do not exist are NaN.
PointsT to_points_artifact(const NetworkResult& result);

/// Points, statistics, tests, every observation, findings.
SurveyNetworkT to_network_artifact(const NetworkResult& result, const AdjustOptions& options);

/// Control points of an artifact. Without covariance their sigmas are taken; without these either they are without
/// error.
ControlPoints control_from_artifact(const PointsT& points);

}  // namespace plumbline::survey

// From the artifact of a network adjustment to what its page shows.
#pragma once

#include "artifacts/points.hpp"
#include "artifacts/survey_network.hpp"
#include "show/report/report.hpp"

namespace plumbline::report {

/// `in_file_axes`: the same network in the axes of its file, for the table of coordinates; null: E, N, H. `points`: its
/// points with their full covariance, for what neighbours are known relative to each other; null: unknown.
NetworkPage network_page(const SurveyNetworkT& network, const SurveyNetworkT* in_file_axes = nullptr,
                         const PointsT* points = nullptr);

/// Covariance of a standard error ellipsoid [m^2].
Eigen::Matrix3d covariance_of(const NetworkEllipsoidT& ellipsoid);

}  // namespace plumbline::report

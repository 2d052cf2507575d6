// From the artifact of a network adjustment to what its page shows.
#pragma once

#include "artifacts/survey_network.hpp"
#include "report/report.hpp"

namespace plumbline::report {

NetworkPage network_page(const SurveyNetworkT& network);

/// Covariance of a standard error ellipsoid [m^2].
Eigen::Matrix3d covariance_of(const NetworkEllipsoidT& ellipsoid);

}  // namespace plumbline::report

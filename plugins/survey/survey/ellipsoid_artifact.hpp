// Error ellipsoid of a point, as artifacts and pages show it.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>

#include "artifacts/survey_network.hpp"

namespace plumbline::survey {

/// Of a 3x3 covariance [m^2]; components that are nan count as without error.
std::unique_ptr<NetworkEllipsoidT> ellipsoid_artifact(const std::string& id, const Eigen::Matrix3d& covariance);

}  // namespace plumbline::survey

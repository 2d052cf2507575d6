// Adjusted points as files for other programs.
#pragma once

#include <string>

#include "artifacts/points.hpp"
#include "artifacts/survey_network.hpp"

namespace plumbline::survey {

/// {"frame": "E, N, H [m]", "points": [{"id", "position", "sigma", "covariance": [[3], [3], [3]]}, ...]}; what is not
/// known is null. Grows with the number of points, not with its square.
/// `network` has the covariance of each point where `points` has no joint one.
std::string points_as_json(const PointsT& points, const SurveyNetworkT& network);

/// NumPy format 1.0, little-endian float64, C order: the 3n x 3n covariance [m^2], or 0 x 0 if it is not wanted or not
/// known.
std::string covariance_as_npy(const PointsT& points, bool wanted);

}  // namespace plumbline::survey

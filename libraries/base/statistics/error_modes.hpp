// Errors of points taken apart into what a survey asks of: heights, plan, and the motions of the whole block.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "base/statistics/trial_summary.hpp"

namespace plumbline::statistics {

struct ErrorMode {
  std::string name;  ///< "heights", "plan", "shift", "turn" (about the vertical), "tilt", "scale"
  StatedError error;
};

/// `positions`: x, y, z of point after point [m], z up; `errors` and `covariance` in the same order, [m] and [m²].
/// Root mean squares are per point: what the mode alone moves the points by. A part that the points cannot show (the
/// scale of a single point) is left out. Predicted, NEES and freedom are nan without a covariance (size 0), NEES where
/// it is singular.
std::vector<ErrorMode> error_modes(const Eigen::VectorXd& positions, const Eigen::VectorXd& errors,
                                   const Eigen::MatrixXd& covariance);

}  // namespace plumbline::statistics

// Equation (7): registration with points that may be wrong altogether.
#pragma once

#include <cstdint>

#include "control/registration/rigid_registration.hpp"

namespace plumbline::registration {

enum class Estimator {
  least_squares,  ///< (6)
  huber,          ///< convex: pulls, never rejects
  cauchy,
  tukey,          ///< redescending: starts from the best triple
  geman_mcclure,  ///< redescending: starts from the best triple
  truncated,      ///< truncated least squares by graduated non-convexity: Yang, Antonante, Tzoumas & Carlone (2020)
  ransac,         ///< best triple, then least squares of what agrees with it: Fischler & Bolles (1981)
};

struct RobustOptions {
  Options fit;
  Estimator estimator = Estimator::least_squares;
  /// Residual in space over its standard deviation at which the loss departs from squares or a point is rejected; 0:
  /// the estimator's own (2.5 huber and cauchy, 6 tukey, 4 geman_mcclure; truncated and ransac 4.03, the 99.9 % point
  /// of chi-squared with 3 degrees of freedom).
  double threshold = 0;
  /// Standard deviation of a coordinate difference [m] where no covariance is given or weights are equal; 0: from the
  /// median residual of the best triple.
  double sigma = 0;
  uint64_t seed = 1;  ///< of the triples, above 30 points
};

struct RobustRegistration {
  Registration fit;            ///< of the points in `used`
  std::vector<int> used;       ///< columns of the correspondences that took part, weight above 0
  Eigen::VectorXd weights;     ///< one a point, 0 … 1
  Eigen::Matrix3Xd residuals;  ///< of all points, rejected ones too [m]
  /// Residual over its standard deviation; of a rejected point over that of its prediction.
  Eigen::Matrix3Xd w;
};

/// Throws DegenerateRegistration if fewer than three points that span a triangle are left, and what register_points()
/// throws.
RobustRegistration register_robust(const Correspondences& points, const RobustOptions& options);

}  // namespace plumbline::registration

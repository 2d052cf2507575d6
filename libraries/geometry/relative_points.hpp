// What points are known relative to each other, from their joint covariance.
#pragma once

#include <Eigen/Core>
#include <utility>
#include <vector>

namespace plumbline {

/// Confidence ellipse of two coordinates, from their covariance [m^2].
struct ConfidenceEllipse {
  double major = 0, minor = 0;  ///< semi-axes [m]
  double azimuth = 0;  ///< of the major axis, from the second coordinate (north) to the first (east) [rad], 0 .. pi
};
/// `factor` scales the standard ellipse: 2.4477 for 95 %. NaN where the covariance is.
ConfidenceEllipse confidence_ellipse(const Eigen::Matrix2d& covariance, double factor);

/// Covariance of point b - point a, 3 x 3: S_aa + S_bb - S_ab - S_ba, from the 3n x 3n covariance of all points.
Eigen::Matrix3d relative_covariance(const Eigen::MatrixXd& covariance, Eigen::Index a, Eigen::Index b);

/// Pairs (i < j) of which one is among the `count` nearest of the other, in ascending order; positions with NaN have no
/// neighbours. O(n^2).
std::vector<std::pair<int, int>> neighbours(const std::vector<Eigen::Vector3d>& positions, int count);

}  // namespace plumbline

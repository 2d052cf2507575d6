// How a panel sits if it follows its fixings: the rigid motion that fits the deviations of its anchors best, and what
// is left of them, as linear functions of the deviations, so that their covariance follows.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace plumbline {

/// For n fixings with deviations d = (dx0, dy0, dz0, dx1, ...) [m]: motion = pose · d, residuals = residual · d.
struct PanelMotion {
  Eigen::MatrixXd pose;      ///< 6 × 3n: translation of the panel's centre [m], rotation vector about it [rad]
  Eigen::MatrixXd residual;  ///< 3n × 3n: deviations minus those that the motion explains
  int rotations = 0;         ///< about how many axes the fixings determine the rotation: 0 (one), 2 (a line), 3
};

/// Least squares over small rotations, d = t + r × (p − centre), every fixing of equal weight. A rotation that the
/// fixings cannot tell stays zero: all of it for one fixing, that about their line for fixings in a line (within a
/// centimetre). `fixings` and `centre` in one frame [m], at least one fixing.
PanelMotion fit_panel(const std::vector<Eigen::Vector3d>& fixings, const Eigen::Vector3d& centre);

/// A point that lies so near to the line about which a panel's turn is open is told by what holds it there [m]: a turn
/// of 10 mm on a metre moves it by half a millimetre. The same for who judges panels and who plans them.
inline constexpr double kOpenArm = 0.05;

/// Unless said otherwise, how far from a panel's box an anchor may be and still count as one of its fixings [m].
inline constexpr double kPanelReach = 0.3;

/// Distance of a point from an axis-parallel box [m]; 0 inside. All in the box's own axes.
double distance_from_box(const Eigen::Vector3d& low, const Eigen::Vector3d& high, const Eigen::Vector3d& point);

}  // namespace plumbline

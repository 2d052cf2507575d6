// How a panel sits if it follows its fixings: the rigid motion that fits the deviations of its anchors best, and what
// is left of them, as linear functions of the deviations, so that their covariance follows.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace plumbline {

/// For n fixings with deviations d = (dx0, dy0, dz0, dx1, ...) [m]: motion = pose · d, residuals = residual · d.
struct PanelMotion {
  Eigen::MatrixXd pose;      ///< 6 × 3n: translation of the panel's centre [m], rotation vector about it [rad]
  Eigen::MatrixXd residual;  ///< 3n × 3n: deviations minus those that the motion explains
  int rotations = 0;         ///< about how many axes the fixings determine the rotation: 0 (one), 2 (a line), 3
  /// Of fixings in a line: the turn about it, which they do not tell, as a motion of the centre; else zero.
  Eigen::Matrix<double, 6, 1> open = Eigen::Matrix<double, 6, 1>::Zero();
};

/// Least squares over small rotations, d = t + r × (p − centre), every fixing of equal weight. A rotation that the
/// fixings cannot tell stays zero: all of it for one fixing, that about their line for fixings in a line (kTurnArm).
/// `fixings` and `centre` in one frame [m], at least one fixing.
PanelMotion fit_panel(const std::vector<Eigen::Vector3d>& fixings, const Eigen::Vector3d& centre);

/// So far the fixings of a panel must lie off a line (root of the sum of squares) to tell how it is turned about that
/// [m]. The same for who judges panels and who plans them.
inline constexpr double kTurnArm = 0.01;

/// A point that lies so near to the line about which a panel's turn is open is told by what holds it there [m]: a turn
/// of 10 mm on a metre moves it by half a millimetre. The same for who judges panels and who plans them.
inline constexpr double kOpenArm = 0.05;

/// How a turn that is open (6 x 1, its rotation of length `turn` [rad]) follows what holds one place of the panel in
/// one direction: by lift = open / (held * open) for a metre, where `held` (1 x 6) is the movement of that place. What
/// the others tell is told less lift * held of it. Nothing where the place is so near to the line of the turn that it
/// does not tell it (kOpenArm).
std::optional<Eigen::Matrix<double, 6, 1>> lift_of(const Eigen::Matrix<double, 6, 1>& open, double turn,
                                                   const Eigen::Matrix<double, 1, 6>& held);

/// An edge of a panel that something else holds out of the panel's plane and in no other way (the stack joint of
/// unitised panels, a starter sill): it slides up, down and along. Ends in the frame of the fixings [m].
struct HeldEdge {
  Eigen::Vector3d left, right, out;  ///< out: unit vector
};

/// A panel on fixings in a line whose edge is held: beside the deviations of n fixings, x has how far out the edge is
/// held at its left and its right end [m]. A stiff panel on two brackets touches a third place; it is the middle of the
/// edge, because what is left at its ends is what the joint, softer than brackets, has to give.
struct HeldMotion {
  PanelMotion motion;                ///< pose 6 x (3n + 2), residual 3n x (3n + 2), rotations 3
  Eigen::RowVectorXd twist;          ///< 1 x (3n + 2): left end of the edge less where it is held; the right one: minus
  Eigen::Matrix<double, 6, 1> lift;  ///< motion for a metre of the edge's middle
};

/// Nothing where a turn about a line is not all that is open, or the edge is on that line. `centre` as in fit_panel().
std::optional<HeldMotion> hold_edge(const PanelMotion& hung, const Eigen::Vector3d& centre, const HeldEdge& edge);

/// How much of what a place of the panel is off by it hands on to another, both along `out`: of the held edge to the
/// edge that carries the next panel, mostly minus what lies above the brackets over what lies below them.
double handed_on(const HeldMotion& held, const Eigen::Vector3d& centre, const Eigen::Vector3d& place,
                 const Eigen::Vector3d& out);

/// Unless said otherwise, how far from a panel's box an anchor may be and still count as one of its fixings [m].
inline constexpr double kPanelReach = 0.3;

/// Distance of a point from an axis-parallel box [m]; 0 inside. All in the box's own axes.
double distance_from_box(const Eigen::Vector3d& low, const Eigen::Vector3d& high, const Eigen::Vector3d& point);

}  // namespace plumbline

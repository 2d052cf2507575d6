// Pose of a panel on its hooks as a linear function of what the hooks do, and of what depends on it.
#pragma once

#include <map>

#include "loop/fit/facade.hpp"

namespace plumbline::loop {

/// The panel's twist (translation of its centre [m], rotation vector times `arm` [m]) is solve * m, where m are the
/// movements of its hooks in the directions that they hold [m]: least squares, every direction of equal weight. What no
/// hook tells stays 0.
struct PanelPose {
  double arm = 1;         ///< [m] half the panel's diagonal: a rotation as the way it moves a corner
  Eigen::MatrixXd hooks;  ///< h x 6: movement of the held directions from the twist
  Eigen::MatrixXd solve;  ///< 6 x h
  Eigen::MatrixXd open;   ///< 6 x f: twists that no hook tells; f = 0 for a panel that hangs as it should
  /// h x g: movements of the hooks that a rigid panel does not follow (four hooks that hold it out of plane: g = 1).
  Eigen::MatrixXd strain;
  struct Held {
    std::size_t bracket;
    Eigen::Vector3d direction;  ///< unit vector, in the frame
    bool is_below = false;      ///< no hook of this panel, but one of what it stands on
  };
  std::vector<Held> held;  ///< the h directions: its hooks in their order, then those of what it stands on
  /// Of a panel that stands on another: its twist is solve of its own hooks, plus lift times how far out that one's
  /// twist brings the edge. The same as `solve` over all that is held, in terms that do not grow with the column.
  struct Stand {
    std::size_t carrier;
    Eigen::Matrix<double, 1, 6> edge;  ///< of the carrier's twist
    Eigen::Matrix<double, 6, 1> lift;
  };
  std::optional<Stand> stand;
  /// What a metre that a bottom edge is off its support (Support::sigma of that panel) does to the twist.
  std::vector<std::pair<std::size_t, Eigen::Matrix<double, 6, 1>>> seats;

  /// 1 x 6: movement of a point of the panel along a direction.
  Eigen::Matrix<double, 1, 6> movement(const Panel& panel, const Eigen::Vector3d& point,
                                       const Eigen::Vector3d& direction) const;
  /// Whether the hooks tell a value with this row. Where a turn about a line is all that is open, as with two brackets:
  /// it lies within kOpenArm of that line, as the judgement has it; else it moves less than 0.05 for a unit of any open
  /// twist.
  bool tells(const Eigen::Matrix<double, 1, 6>& row) const;
  /// How many of `held` are given by what they hold alone: all, or without those of the panels below.
  Eigen::Index own() const;
};

/// Hooks on brackets that were not measured are left out: what they hold is then open.
PanelPose pose_of(const Panel& panel, const std::vector<Bracket>& brackets);

/// Of all panels, the turn about their brackets' line closed where something holds their bottom edge: it follows the
/// hooks of the panels below, too, as they are planned or hang. Where those do not tell, it stays open.
std::vector<PanelPose> poses_of(const Facade& facade);

/// What a value is judged as.
enum class Quantity { corner, gap, step };

/// A length that must lie between two limits: a corner of a panel or a joint at one of its ends. Linear in the twists
/// of up to two panels.
struct JudgedValue {
  Quantity quantity = Quantity::corner;
  std::size_t panel = 0;  ///< of a joint: that which comes first, `a`
  int corner = -1, direction = -1;
  int joint = -1, end = -1;
  double constant = 0;  ///< [m] nominal width of a gap; else 0
  double low = 0, high = 0;
  std::vector<std::pair<std::size_t, Eigen::Matrix<double, 1, 6>>> rows;  ///< by panel
  std::vector<std::pair<std::size_t, double>> edges;  ///< factors of manufacture: panel * 5 + side, 4 for its face
  std::string words(const Facade& facade) const;
};

/// All values that are judged and that the hooks tell, corners panel by panel, then joints; `untold` names the others.
std::vector<JudgedValue> judged_values(const Facade& facade, const std::vector<PanelPose>& poses,
                                       std::vector<std::string>& untold);

/// d(value)/d(movement of brackets): by bracket, in the frame.
std::map<std::size_t, Eigen::RowVector3d> bracket_gradient(const JudgedValue& value,
                                                           const std::vector<PanelPose>& poses);

/// How errors reach some judged values: of the brackets they rest on as measured and as set, of manufacture. Settings
/// and stations are of brackets that are still to be set.
struct ValueErrors {
  std::vector<std::size_t> brackets;  ///< that the values rest on
  /// Covariance of the values [m²] by the measured deviations, jointly; of these by what campaigns do not share; by
  /// settings; by where robots stand; by manufacture.
  Eigen::MatrixXd measured, own, setting, station, made;
  Eigen::MatrixXd with_own;                ///< values x 3 brackets: covariance with what `own` has of each [m²]
  std::vector<Eigen::Matrix3d> own_alone;  ///< of each bracket by itself [m²]
  /// Something rare and large that no standard deviation says: a bracket that slips on tightening, a plate that was
  /// knocked before it was measured, control likewise.
  struct RareEvent {
    double share = 0;       ///< how often
    Eigen::MatrixXd shift;  ///< values x k: what k independent standard normal numbers do to the values [m]
  };
  std::vector<RareEvent> rare;
  /// Of all together, rare events with their share: their second moment, though not their tails.
  Eigen::MatrixXd covariance() const;
  /// If nothing rare happens but that at this place of `rare` (-1: nothing).
  Eigen::MatrixXd covariance_when(int event) const;
};
ValueErrors errors_of(const std::vector<const JudgedValue*>& values, const Facade& facade,
                      const std::vector<PanelPose>& poses);

}  // namespace plumbline::loop

// What hangs on what: brackets that can be set, panels with their hooks, joints between panels. One struct for planner,
// gate and simulation. All places in one frame [m]; directions of one who stands before the facade: right, up, out.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace plumbline::loop {

inline constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

/// Names of the three directions, in the order of the columns of `axes`.
inline constexpr std::array<const char*, 3> kDirections = {"right", "up", "out"};

/// Columns right, up, out for an outward normal; `outward` need not be horizontal or of unit length, but not vertical.
Eigen::Matrix3d facade_axes(const Eigen::Vector3d& outward);

/// How far brackets of a type can be set, along right, up, out [m].
struct BracketType {
  std::string name = "assumed";
  Eigen::Vector3d low{-0.020, -0.015, -0.025}, high{0.020, 0.015, 0.025};
  Eigen::Vector3d step = Eigen::Vector3d::Zero();  ///< of a shim or a toothed plate; 0: continuous
};

/// A bracket at an anchor.
struct Bracket {
  std::string id;
  int floor = 0;
  Eigen::Vector3d design = Eigen::Vector3d::Zero();                 ///< where its hook should be, unset
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();               ///< frame_from_facade: columns right, up, out
  Eigen::Vector3d deviation = Eigen::Vector3d::Constant(kUnknown);  ///< as-built minus design (14); nan: not measured
  BracketType type;
  bool fixed = false;  ///< planned as it stands: a panel hangs on it, or it was set; `deviation` is that of the hook
  std::string basis;   ///< hash of its own measurement by the last campaign; empty: of `deviation`
  int campaigns = 0;   ///< that `deviation` rests on; 0: not combined
  Eigen::Vector3d difference_sigma = Eigen::Vector3d::Zero();  ///< to the place of campaigns before [m]; 0: unknown
  bool is_sill = false;          ///< a measured place of a sill: panels stand on it, and nobody sets it
  bool holds_unplanned = false;  ///< a panel of the design hangs on it, or may, that is none of Facade::panels
  bool measured() const { return deviation.allFinite(); }
  bool stays() const { return fixed || is_sill; }
};

/// What a hook takes up; the other directions slide.
struct Hook {
  std::size_t bracket = 0;
  std::array<bool, 3> holds = {true, true, true};  ///< right, up, out
};

/// Limits of a panel's corners [m]: how far along each direction, and how far back; nan: as far.
struct CornerLimits {
  double right = 0.005, up = 0.005, out = 0.005;
  double left = kUnknown, down = kUnknown, in = kUnknown;
  double operator[](int direction) const { return direction == 0 ? right : direction == 1 ? up : out; }
  double back(int direction) const {
    const double own = direction == 0 ? left : direction == 1 ? down : in;
    return std::isnan(own) ? (*this)[direction] : own;
  }
};

/// What holds a panel's bottom edge out of its plane, and in no other way: the panel below, a measured sill, or one
/// that is only assumed to be in place. As the judgement found it (PanelSupport of the deviation).
struct Support {
  int panel = -1;                                     ///< of Facade::panels; -1: a sill
  std::vector<std::pair<std::size_t, double>> sills;  ///< brackets, and their part in how far out the edge is held
  Eigen::Vector3d place = Eigen::Vector3d::Zero();    ///< middle of the edge
  double sigma = 0;                                   ///< of the edge against what holds it [m]
  double sill_sigma = 0;                              ///< of a sill that is assumed: its part of `sigma` [m]
};

struct Panel {
  std::string id, name;
  int floor = 0;
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  std::array<Eigen::Vector3d, 4> corners = {};  ///< bottom left, bottom right, top left, top right, seen from outside
  std::vector<Hook> hooks;
  CornerLimits limits;
  std::optional<Support> below;
  std::string below_unknown;            ///< it is held below, and this is why nobody knows where; empty: it is known
  std::vector<std::string> depends_on;  ///< ids of panels that hang first
  bool installed = false;
  std::string open;  ///< why it cannot be GO whatever its probability, in words; empty: nothing is known against it
};

/// Sides of a panel as seen from outside.
enum class Side { left, right, bottom, top };

/// The gap from panel `a` to panel `b`, looked at where it begins and where it ends.
struct Joint {
  std::size_t a = 0, b = 0;
  Side side_of_a = Side::right, side_of_b = Side::left;
  Eigen::Vector3d across = Eigen::Vector3d::UnitX();           ///< unit vector from a to b
  std::array<Eigen::Vector3d, 2> on_a = {}, on_b = {};         ///< the two ends
  double nominal = 0, least = 0, most = 0;                     ///< width [m]
  double step_most = std::numeric_limits<double>::infinity();  ///< out of plane from a to b [m]
};

/// Standard deviations beside those of the measured anchors [m].
struct ErrorModel {
  double setting = 0.0005;       ///< of a bracket as it is set against what was asked, each direction
  double station = 0;            ///< common to all brackets that one robot sets on one floor, each direction
  double edge = 0.0005;          ///< of an edge of a panel, within its plane
  double face = 0.0005;          ///< of a panel's face out of its plane
  double guard_factor = 1.645;   ///< k
  double slip_share = 0;         ///< of brackets that slip on tightening, besides `setting`
  double slip = 0.002;           ///< how far these slip, each direction
  double knock_share = 0;        ///< of plates that were knocked before they were measured first: no campaign tells
  double knock = 0.003;          ///< how far, each direction
  double control_share = 0;      ///< of storeys whose control was knocked before it was measured from
  double control_knock = 0.006;  ///< how far, in height
};

struct Facade {
  std::vector<Bracket> brackets;
  std::vector<Panel> panels;
  std::vector<Joint> joints;
  Eigen::MatrixXd covariance;  ///< of the deviations, 3n x 3n [m²], order of the brackets; what was not measured: any
  Eigen::MatrixXd own;         ///< likewise, without what all campaigns share (control); empty: unknown
  /// Of where robots put what they set, by what they know of their own places, 3n x 3n [m²], order of the brackets:
  /// besides ErrorModel::station. Empty: none.
  Eigen::MatrixXd stations;
  ErrorModel errors;
};

/// What is wrong with a facade, in words with the place; empty if nothing is. Sizes, repeated ids, indices, limits, a
/// cycle in depends_on (named panel by panel), brackets with an empty range.
std::vector<std::string> faults_of(const Facade& facade);

/// Panels in an order that depends_on allows, lower floors first. Throws std::runtime_error that names a cycle.
std::vector<std::size_t> installation_order(const std::vector<Panel>& panels);

}  // namespace plumbline::loop

// A panel that follows its anchors, and the lengths that it is judged by. Private to libraries/building/judgement.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "building/ifc/tolerance_source.hpp"
#include "building/judgement/conformance.hpp"
#include "building/judgement/figures.hpp"
#include "building/judgement/linear_length.hpp"
#include "building/judgement/panels.hpp"
#include "geometry/panel_fit.hpp"

namespace plumbline::judgement {

/// Panels farther apart than this are no neighbours [m].
inline constexpr double kWidestJoint = 0.2;

/// Panels that face more differently than this share no joint: at a corner they meet in an edge.
inline const double kOneFacade = std::cos(20 * std::numbers::pi / 180);

/// How far panels of one facade may be set back from one another and still be neighbours: `turn` is the cosine of the
/// directions they face, by which a facade of panels so wide bends [m].
inline double most_set_back(double turn, double width) {
  return 0.2 + std::tan(std::acos(std::min(1.0, turn))) * width;
}

/// Not judged where no tolerance is given: its value is nan then.
inline Tolerance tolerance_for(const Tolerances& tolerances, Axis axis, const Tolerance& fallback = {}) {
  const auto found = tolerances.find(axis);
  return found == tolerances.end() ? fallback : found->second;
}

/// Of a length that says nothing of a position (a turn, a warp): half of what lies between the two sides, on either.
inline Tolerance about_zero(Tolerance tolerance) {
  tolerance.value = 0.5 * (tolerance.value + tolerance.lower()), tolerance.below = nan;
  return tolerance;
}

/// A box in the axes of a panel along right, up and out.
inline std::pair<Eigen::Vector3d, Eigen::Vector3d> box_in(const PanelCase& panel, const Eigen::Vector3d& low,
                                                          const Eigen::Vector3d& high, const ifc::FacadeFrame& axes) {
  Eigen::Vector3d least = Eigen::Vector3d::Constant(1e300), most = -least;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d own(corner & 1 ? high.x() : low.x(), corner & 2 ? high.y() : low.y(),
                              corner & 4 ? high.z() : low.z());
    const Eigen::Vector3d p = panel.frame_from_panel * own;
    const Eigen::Vector3d seen(axes.right.dot(p), axes.up.dot(p), axes.out.dot(p));
    least = least.cwiseMin(seen), most = most.cwiseMax(seen);
  }
  return {least, most};
}

/// That of its body.
inline std::pair<Eigen::Vector3d, Eigen::Vector3d> box_in(const PanelCase& panel, const ifc::FacadeFrame& axes) {
  return box_in(panel, panel.low, panel.high, axes);
}

/// What holds the bottom edge of a panel: how far out, at both ends of what is common to both.
struct Seat {
  HeldEdge edge;
  LinearLength left, right;
  bool tells_turn = true;  ///< both ends are known; else only their middle is
};

/// A panel on its anchors: every length is a row that acts on their deviations and, where its bottom edge is held, on
/// how far out that is at both ends.
class JudgedPanel {
 public:
  /// `own`: positions of its anchors in `all`.
  JudgedPanel(const PanelCase& panel, const DeviationInputs& inputs, const DifferenceSet& all,
              const std::vector<std::size_t>& own, const DeviationOptions& options)
      : panel_(panel), own_(own), axes_(panel.facade), options_(options) {
    const DifferenceSet part = all.subset(own);
    x_ = part.difference, covariance_ = part.covariance.dense();
    for (const std::size_t anchor : part.anchors) fixings_.push_back(inputs.anchors[anchor].design);
    centre_ = panel.frame_from_panel * Eigen::Vector3d(0.5 * (panel.low + panel.high));
    motion_ = fit_panel(fixings_, centre_);
    find_box();
    vertical_ = tolerance_for(panel.tolerances, Axis::vertical);
    sideways_ = tolerance_for(panel.tolerances, Axis::horizontal);
    outward_ = tolerance_for(panel.tolerances, Axis::out_of_plane, sideways_);
    in_plane_ = tolerance_for(panel.tolerances, Axis::in_plane, sideways_);
    joint_ = tolerance_for(panel.tolerances, Axis::joint);
    out_of_place_ = about_zero(outward_);
    if (!axes_.confirmed) leave_out();
  }

  /// Whether its anchors are in a line, so that something else has to tell how it is turned about that.
  bool is_in_line() const { return motion_.rotations == 2; }

  /// How much of what its held edge is off by another place of it is, both along `out`; nothing where that edge does
  /// not tell the turn.
  std::optional<double> hold(const Seat& seat, const LengthBasis& basis, const Eigen::Vector3d& carrying) {
    const std::optional<HeldMotion> held = hold_edge(motion_, centre_, seat.edge);
    if (!held) return {};
    motion_ = held->motion, seat_ = seat;
    if (seat.tells_turn) twist_ = held->twist;
    const Eigen::Index n = x_.size();
    x_.conservativeResize(n + 2);
    x_.tail<2>() << basis.value(seat.left), basis.value(seat.right);
    if (covariance_.size() > 0) add_to_covariance(basis);
    return handed_on(*held, centre_, carrying, seat.edge.out);
  }

  /// A length of this panel, as what it is made of.
  LinearLength in_full(const Eigen::RowVectorXd& row) const {
    LinearLength length;
    for (std::size_t i = 0; i < own_.size(); ++i)
      length.anchors[own_[i]] = row.segment<3>(3 * static_cast<Eigen::Index>(i));
    if (seat_) length.add(seat_->left, row[row.size() - 2]), length.add(seat_->right, row[row.size() - 1]);
    return length;
  }
  double value(const Eigen::RowVectorXd& row) const { return row.dot(x_); }

  void fill(PanelDeviationT& out) {
    const Eigen::VectorXd motion = motion_.pose * x_;
    out.shift = motion.head<3>(), out.rotation = motion.tail<3>();
    for (std::unique_ptr<JudgedLengthT>* length :
         {&out.out_of_plane, &out.sideways, &out.vertical, &out.tilt, &out.warp, &out.misfit, &out.corner})
      *length = std::make_unique<JudgedLengthT>();
    judge(*out.out_of_plane, translation(axes_.out), outward_);
    judge(*out.sideways, translation(axes_.right), sideways_);
    judge(*out.vertical, translation(axes_.up), vertical_, true);
    if (panel_.tolerances.contains(Axis::in_plane)) {
      Eigen::MatrixXd rows(2, x_.size());
      rows << translation(axes_.right), translation(axes_.up);
      out.in_plane = std::make_unique<JudgedLengthT>();
      judge(*out.in_plane, rows, in_plane_);
    }
    angle(axes_.right, 1, out.lean, out.u_lean);
    angle(axes_.up, -1, out.turn, out.u_turn);  // right × out points down
    angle(axes_.out, 1, out.roll, out.u_roll);
    if (motion_.rotations > 0)
      for (const Eigen::Vector3d& fixing : fixings_)
        judge(*out.tilt, -skew(fixing - centre_) * motion_.pose.bottomRows<3>(), out_of_place_);
    if (motion_.rotations == 3 && fixings_.size() > 3) judge_residuals(*out.warp, {axes_.out}, out_of_place_);
    if (twist_.size() > 0) judge(*out.warp, twist_, out_of_place_);
    out.warp->value = std::abs(out.warp->value);  // two corners stand out as far as the other two stand back
    if (fixings_.size() > 1) judge_residuals(*out.misfit, {axes_.right, axes_.up}, in_plane_);
    fill_corners(out);
    if (!axes_.confirmed) drop_signs(out);
    const Conformance found = conformance(x_, covariance_, limits_, options_.risk, options_.tau);
    for (std::size_t i = 0; i < limits_.size(); ++i)
      lengths_[i]->verdict = std::max(lengths_[i]->verdict, verdict_of(found.of_each[i], options_.risk));
    out.pass_probability = found.probability, out.tau_pass = found.tau_pass, out.tau_fail = found.tau_fail;
    if (!limits_.empty()) out.verdict = verdict_of(found.probability, options_.risk);
    if (!axes_.confirmed) out.tau_pass = std::numeric_limits<double>::infinity();
    if (left_out_) out.pass_probability = nan;
  }

  /// Eigen::RowVectorXd of the movement along `direction` of a point of the panel; empty where the anchors cannot tell
  /// it.
  Eigen::RowVectorXd movement(const Eigen::Vector3d& point, const Eigen::Vector3d& direction) const {
    if (motion_.rotations == 0) return {};
    if (motion_.rotations == 2) {
      // The turn about the fixings' line is open: what it would move may not be asked.
      const Eigen::Vector3d line = line_of_fixings();
      const Eigen::Vector3d arm = line.cross(point - fixings_[0]);
      if (std::abs(arm.dot(direction)) > kOpenArm) return {};
    }
    Eigen::MatrixXd rows(3, 6);
    rows << Eigen::Matrix3d::Identity(), -skew(point - centre_);
    return direction.transpose() * rows * motion_.pose;
  }

  /// Two anchors, or more in one line, tell five of the six ways in which a stiff body moves. Whether the sixth, a turn
  /// about that line, moves a corner that is held against a limit. Known after fill().
  bool turn_is_open() const { return turn_is_open_; }

  const PanelCase& panel() const { return panel_; }
  const ifc::FacadeFrame& axes() const { return axes_; }
  const Tolerance& joint_tolerance() const { return joint_; }
  /// Too far from another for any joint: cheap, because every two panels are asked.
  bool far_from(const JudgedPanel& other) const {
    return (centre_ - other.centre_).norm() > reach() + other.reach() + kWidestJoint;
  }
  const Eigen::Vector3d& centre() const { return centre_; }
  double reach() const { return 0.5 * (panel_.high - panel_.low).norm(); }
  /// Its box along right, up and out.
  Eigen::Vector3d low, high;
  /// The same along those of another.
  std::pair<Eigen::Vector3d, Eigen::Vector3d> box_in(const ifc::FacadeFrame& axes) const {
    return judgement::box_in(panel_, axes);
  }
  /// Of its outer side.
  std::pair<Eigen::Vector3d, Eigen::Vector3d> side_in(const ifc::FacadeFrame& axes) const {
    if (panel_.outer.isEmpty()) return box_in(axes);
    return judgement::box_in(panel_, panel_.outer.min(), panel_.outer.max(), axes);
  }
  Eigen::Vector3d at(double right, double up, double out) const {
    return right * axes_.right + up * axes_.up + out * axes_.out;
  }

 private:
  void find_box() { std::tie(low, high) = box_in(axes_); }

  /// Of how far out its edge is held, with itself and with what its own anchors are off by.
  void add_to_covariance(const LengthBasis& basis) {
    const Eigen::Index n = covariance_.rows();
    covariance_.conservativeResize(n + 2, n + 2);
    const std::array<const LinearLength*, 2> ends = {&seat_->left, &seat_->right};
    for (Eigen::Index e = 0; e < 2; ++e) {
      for (Eigen::Index i = 0; i < n; ++i) {
        LinearLength own;
        own.anchors[own_[static_cast<std::size_t>(i / 3)]] = Eigen::RowVector3d::Unit(i % 3);
        covariance_(i, n + e) = covariance_(n + e, i) = basis.covariance(own, *ends[e]);
      }
      for (Eigen::Index f = 0; f < 2; ++f) covariance_(n + e, n + f) = basis.covariance(*ends[e], *ends[f]);
    }
  }

  double uncertainty(const Eigen::RowVectorXd& row) const {
    if (covariance_.size() == 0) return nan;
    return std::sqrt(std::max(0.0, (row * covariance_ * row.transpose()).value()));
  }
  Eigen::RowVectorXd translation(const Eigen::Vector3d& direction) const {
    return direction.transpose() * motion_.pose.topRows<3>();
  }

  Eigen::Vector3d line_of_fixings() const {
    Eigen::Vector3d line = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& p : fixings_)
      if ((p - fixings_[0]).norm() > line.norm()) line = p - fixings_[0];
    return line.normalized();
  }

  /// Rotation about an axis; nan where the fixings stand in a line that is not square to it.
  void angle(const Eigen::Vector3d& axis, double sign, double& out, double& u) const {
    if (motion_.rotations == 0) return;
    if (motion_.rotations == 2 && std::abs(line_of_fixings().dot(axis)) > 0.05) return;
    const Eigen::RowVectorXd row = sign * axis.transpose() * motion_.pose.bottomRows<3>();
    out = row.dot(x_), u = uncertainty(row);
  }

  /// What depends on a side that is not confirmed, or on a plane that is only guessed, is not held against a limit: a
  /// panel would fail by the guess.
  void leave_out() {
    const bool guessed = axes_.source <= ifc::FacadeSource::guess;
    skip_out_ = guessed || (!std::isnan(outward_.below) && outward_.below != outward_.value);
    skip_along_ = guessed;
  }

  /// On which side the outside is is not known: neither are the signs.
  static void drop_signs(PanelDeviationT& out) {
    for (JudgedLengthT* length : {out.out_of_plane.get(), out.sideways.get(), out.corner.get()})
      length->value = std::abs(length->value);
    out.lean = std::abs(out.lean), out.roll = std::abs(out.roll);
  }

  bool skipped(const Tolerance& tolerance) const {
    return &tolerance == &outward_ || &tolerance == &out_of_place_ ? skip_out_ : skip_along_;
  }

  /// Takes a signed value (one row) or the length of a vector among what the panel is held against; of several for one
  /// `shown` the largest is. `level`: it does not ask which way the panel faces.
  void judge(JudgedLengthT& shown, const Eigen::MatrixXd& rows, const Tolerance& tolerance, bool level = false) {
    const Eigen::VectorXd vector = rows * x_;
    const bool one = rows.rows() == 1;
    const double value = one ? vector[0] : vector.norm();
    if (!(std::abs(value) <= std::abs(shown.value))) {
      shown.value = value;
      shown.u = uncertainty(one || !(value > 0) ? Eigen::RowVectorXd(rows.row(0))
                                                : Eigen::RowVectorXd(vector.normalized().transpose() * rows));
      shown.tolerance = one ? tolerance.limit_of(value) : about_zero(tolerance).value;
    }
    if (std::isnan(tolerance.value)) return;
    if (!level && skipped(tolerance)) {
      shown.tolerance = nan, left_out_ = true;
      return;
    }
    const double above = one ? tolerance.value : about_zero(tolerance).value;
    limits_.push_back({rows, above, tolerance.lower(), ifc::is_default_tolerance(tolerance.source)});
    lengths_.push_back(&shown);
  }

  /// Of all fixings, the part of the residual in the span of `directions`.
  void judge_residuals(JudgedLengthT& shown, const std::vector<Eigen::Vector3d>& directions,
                       const Tolerance& tolerance) {
    for (std::size_t i = 0; i < fixings_.size(); ++i) {
      Eigen::MatrixXd rows(static_cast<Eigen::Index>(directions.size()), motion_.residual.cols());
      for (std::size_t k = 0; k < directions.size(); ++k)
        rows.row(static_cast<Eigen::Index>(k)) =
            directions[k].transpose() * motion_.residual.middleRows<3>(3 * static_cast<Eigen::Index>(i));
      judge(shown, rows, tolerance);
    }
  }

  void fill_corners(PanelDeviationT& out) {
    for (const auto& [name, right, up] : {std::tuple{"bottom_left", low.x(), low.y()},
                                          {"bottom_right", high.x(), low.y()},
                                          {"top_left", low.x(), high.y()},
                                          {"top_right", high.x(), high.y()}}) {
      auto corner = std::make_unique<PanelCornerT>();
      corner->name = name;
      corner->design = at(right, up, high.z());
      corner->movement.setConstant(nan);
      Eigen::Vector3d moved = Eigen::Vector3d::Zero();
      for (const auto& [direction, tolerance] :
           {std::pair{axes_.right, &sideways_}, {axes_.up, &vertical_}, {axes_.out, &outward_}}) {
        const Eigen::RowVectorXd row = movement(corner->design, direction);
        moved += (row.size() == 0 ? nan : row.dot(x_)) * direction;
        if (row.size() == 0 && motion_.rotations == 2 && !std::isnan(tolerance->value)) turn_is_open_ = true;
      }
      if (moved.allFinite()) corner->movement = moved;
      if (const Eigen::RowVectorXd row = movement(corner->design, axes_.out); row.size() != 0)
        judge(*out.corner, row, outward_);
      out.corners.push_back(std::move(corner));
    }
  }

  const PanelCase& panel_;
  std::vector<std::size_t> own_;  // positions of its anchors
  Eigen::VectorXd x_;             // what its lengths act on
  Eigen::MatrixXd covariance_;
  std::optional<Seat> seat_;
  Eigen::RowVectorXd twist_;  // of its held edge against what holds it
  ifc::FacadeFrame axes_;
  const DeviationOptions& options_;
  std::vector<Limited> limits_;  // what it is held against, and where each is shown
  std::vector<JudgedLengthT*> lengths_;
  std::vector<Eigen::Vector3d> fixings_;
  Eigen::Vector3d centre_;
  PanelMotion motion_;
  Tolerance vertical_, sideways_, outward_, out_of_place_, in_plane_, joint_;
  bool skip_out_ = false, skip_along_ = false, left_out_ = false, turn_is_open_ = false;
};

}  // namespace plumbline::judgement

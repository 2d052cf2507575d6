// A panel that follows its anchors, and the lengths that it is judged by. Private to libraries/building/judgement.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "building/ifc/tolerance_source.hpp"
#include "building/judgement/conformance.hpp"
#include "building/judgement/figures.hpp"
#include "building/judgement/panels.hpp"
#include "geometry/panel_fit.hpp"

namespace plumbline::judgement {

/// Panels farther apart than this are no neighbours [m].
inline constexpr double kWidestJoint = 0.2;

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

/// A panel on its anchors: every length is a row that acts on the deviations of `part`.
class JudgedPanel {
 public:
  JudgedPanel(const PanelCase& panel, const DeviationInputs& inputs, const judgement::DifferenceSet& part,
              const DeviationOptions& options)
      : panel_(panel), part_(part), covariance_(part.covariance.dense()), axes_(panel.facade), options_(options) {
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

  void fill(PanelDeviationT& out) {
    const Eigen::VectorXd motion = motion_.pose * part_.difference;
    out.shift = motion.head<3>(), out.rotation = motion.tail<3>();
    for (std::unique_ptr<JudgedLengthT>* length :
         {&out.out_of_plane, &out.sideways, &out.vertical, &out.tilt, &out.warp, &out.misfit, &out.corner})
      *length = std::make_unique<JudgedLengthT>();
    judge(*out.out_of_plane, translation(axes_.out), outward_);
    judge(*out.sideways, translation(axes_.right), sideways_);
    judge(*out.vertical, translation(axes_.up), vertical_, true);
    angle(axes_.right, 1, out.lean, out.u_lean);
    angle(axes_.up, -1, out.turn, out.u_turn);  // right × out points down
    angle(axes_.out, 1, out.roll, out.u_roll);
    if (motion_.rotations > 0)
      for (const Eigen::Vector3d& fixing : fixings_)
        judge(*out.tilt, -skew(fixing - centre_) * motion_.pose.bottomRows<3>(), out_of_place_);
    if (motion_.rotations == 3 && fixings_.size() > 3) judge_residuals(*out.warp, {axes_.out}, out_of_place_);
    out.warp->value = std::abs(out.warp->value);  // two corners stand out as far as the other two stand back
    if (fixings_.size() > 1) judge_residuals(*out.misfit, {axes_.right, axes_.up}, in_plane_);
    fill_corners(out);
    if (!axes_.confirmed) drop_signs(out);
    const Conformance found = conformance(part_.difference, covariance_, limits_, options_.risk, options_.tau);
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

  const judgement::DifferenceSet& part() const { return part_; }
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
    Eigen::Vector3d least = Eigen::Vector3d::Constant(1e300), most = -least;
    for (int corner = 0; corner < 8; ++corner) {
      const Eigen::Vector3d own(corner & 1 ? panel_.high.x() : panel_.low.x(),
                                corner & 2 ? panel_.high.y() : panel_.low.y(),
                                corner & 4 ? panel_.high.z() : panel_.low.z());
      const Eigen::Vector3d p = panel_.frame_from_panel * own;
      const Eigen::Vector3d seen(axes.right.dot(p), axes.up.dot(p), axes.out.dot(p));
      least = least.cwiseMin(seen), most = most.cwiseMax(seen);
    }
    return {least, most};
  }
  Eigen::Vector3d at(double right, double up, double out) const {
    return right * axes_.right + up * axes_.up + out * axes_.out;
  }

 private:
  void find_box() { std::tie(low, high) = box_in(axes_); }

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
    out = row.dot(part_.difference), u = uncertainty(row);
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
    const Eigen::VectorXd vector = rows * part_.difference;
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
        moved += (row.size() == 0 ? nan : row.dot(part_.difference)) * direction;
        if (row.size() == 0 && motion_.rotations == 2 && !std::isnan(tolerance->value)) turn_is_open_ = true;
      }
      if (moved.allFinite()) corner->movement = moved;
      if (const Eigen::RowVectorXd row = movement(corner->design, axes_.out); row.size() != 0)
        judge(*out.corner, row, outward_);
      out.corners.push_back(std::move(corner));
    }
  }

  const PanelCase& panel_;
  judgement::DifferenceSet part_;
  Eigen::MatrixXd covariance_;
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

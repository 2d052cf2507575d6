#include "judgement/panels.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <set>

#include "geometry/panel_fit.hpp"
#include "judgement/tolerance.hpp"

namespace plumbline::judgement {
namespace {

using Row = Eigen::RowVectorXd;
using Length = std::unique_ptr<JudgedLengthT>;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
/// Panels farther apart than this are no neighbours [m].
constexpr double kWidestJoint = 0.2;

/// Axes of one who stands before the facade.
struct Axes {
  Eigen::Vector3d up = Eigen::Vector3d::UnitZ(), out, right;
  explicit Axes(const Eigen::Vector3d& outward)
      : out(Eigen::Vector3d(outward.x(), outward.y(), 0).normalized()), right(up.cross(out)) {}
};

double tolerance_for(const Tolerances& tolerances, Axis axis, double fallback) {
  const auto found = tolerances.find(axis);
  return found == tolerances.end() ? fallback : found->second.value;
}

/// A panel on its anchors: every length is a row that acts on the deviations of `part`.
class Panel {
 public:
  Panel(const PanelCase& panel, const DeviationInputs& inputs, const evaluate::DifferenceSet& part,
        const DeviationOptions& options)
      : panel_(panel), part_(part), axes_(inputs.facade_normal), guard_factor_(options.guard_factor) {
    for (const std::size_t anchor : part.anchors) fixings_.push_back(inputs.anchors[anchor].design);
    centre_ = panel.frame_from_panel * Eigen::Vector3d(0.5 * (panel.low + panel.high));
    motion_ = fit_panel(fixings_, centre_);
    find_box();
    vertical_ = tolerance_for(panel.tolerances, Axis::vertical, options.tau);
    sideways_ = tolerance_for(panel.tolerances, Axis::horizontal, options.tau);
    outward_ = tolerance_for(panel.tolerances, Axis::out_of_plane,
                             tolerance_for(panel.tolerances, Axis::horizontal, options.tau));
    in_plane_ = tolerance_for(panel.tolerances, Axis::in_plane, sideways_);
    joint_ = tolerance_for(panel.tolerances, Axis::joint, nan);
  }

  void fill(PanelDeviationT& out) const {
    const Eigen::VectorXd motion = motion_.pose * part_.difference;
    out.shift = motion.head<3>(), out.rotation = motion.tail<3>();
    out.out_of_plane = judge(translation(axes_.out), outward_);
    out.sideways = judge(translation(axes_.right), sideways_);
    out.vertical = judge(translation(axes_.up), vertical_);
    angle(axes_.right, 1, out.lean, out.u_lean);
    angle(axes_.up, -1, out.turn, out.u_turn);  // right × out points down
    angle(axes_.out, 1, out.roll, out.u_roll);
    out.tilt = tilt();
    out.warp = motion_.rotations == 3 && fixings_.size() > 3 ? worst_residual({axes_.out}, outward_) : unknown();
    out.misfit = fixings_.size() > 1 ? worst_residual({axes_.right, axes_.up}, in_plane_) : unknown();
    fill_corners(out);
  }

  /// Row of the movement along `direction` of a point of the panel; empty where the anchors cannot tell it.
  Row movement(const Eigen::Vector3d& point, const Eigen::Vector3d& direction) const {
    if (motion_.rotations == 0) return {};
    if (motion_.rotations == 2) {
      // The turn about the fixings' line is open: what it would move may not be asked.
      const Eigen::Vector3d line = line_of_fixings();
      const Eigen::Vector3d arm = line.cross(point - fixings_[0]);
      if (std::abs(arm.dot(direction)) > 0.05) return {};
    }
    Eigen::MatrixXd rows(3, 6);
    rows << Eigen::Matrix3d::Identity(), -skew(point - centre_);
    return direction.transpose() * rows * motion_.pose;
  }

  Length judge(const Row& row, double tolerance) const {
    Length length = unknown();
    length->value = row.dot(part_.difference), length->u = uncertainty(row);
    length->tolerance = tolerance;
    length->verdict = evaluate::verdict_of(length->value, length->u, tolerance, guard_factor_);
    return length;
  }

  const evaluate::DifferenceSet& part() const { return part_; }
  const PanelCase& panel() const { return panel_; }
  const Axes& axes() const { return axes_; }
  double joint_tolerance() const { return joint_; }
  /// Its box along right, up and out.
  Eigen::Vector3d low, high;
  Eigen::Vector3d at(double right, double up, double out) const {
    return right * axes_.right + up * axes_.up + out * axes_.out;
  }

 private:
  void find_box() {
    low.setConstant(1e300), high.setConstant(-1e300);
    for (int corner = 0; corner < 8; ++corner) {
      const Eigen::Vector3d own(corner & 1 ? panel_.high.x() : panel_.low.x(),
                                corner & 2 ? panel_.high.y() : panel_.low.y(),
                                corner & 4 ? panel_.high.z() : panel_.low.z());
      const Eigen::Vector3d p = panel_.frame_from_panel * own;
      const Eigen::Vector3d seen(axes_.right.dot(p), axes_.up.dot(p), axes_.out.dot(p));
      low = low.cwiseMin(seen), high = high.cwiseMax(seen);
    }
  }

  double uncertainty(const Row& row) const {
    if (part_.covariance.size() == 0) return nan;
    return std::sqrt(std::max(0.0, (row * part_.covariance * row.transpose()).value()));
  }
  static Length unknown() { return std::make_unique<JudgedLengthT>(); }
  Row translation(const Eigen::Vector3d& direction) const { return direction.transpose() * motion_.pose.topRows<3>(); }

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
    const Row row = sign * axis.transpose() * motion_.pose.bottomRows<3>();
    out = row.dot(part_.difference), u = uncertainty(row);
  }

  /// The length of a vector that is linear in the deviations, judged along its own direction.
  Length along_itself(const Eigen::MatrixXd& rows, double tolerance) const {
    const Eigen::VectorXd vector = rows * part_.difference;
    if (!(vector.norm() > 0)) return judge(rows.row(0), tolerance);
    return judge(vector.normalized().transpose() * rows, tolerance);
  }

  Length tilt() const {
    if (motion_.rotations == 0) return unknown();
    Length worst = unknown();
    for (const Eigen::Vector3d& fixing : fixings_) {
      Length moved = along_itself(-skew(fixing - centre_) * motion_.pose.bottomRows<3>(), outward_);
      if (!(moved->value <= worst->value)) worst = std::move(moved);
    }
    return worst;
  }

  /// Over all fixings, the largest part of the residual in the span of `directions`.
  Length worst_residual(const std::vector<Eigen::Vector3d>& directions, double tolerance) const {
    Length worst = unknown();
    for (std::size_t i = 0; i < fixings_.size(); ++i) {
      Eigen::MatrixXd rows(static_cast<Eigen::Index>(directions.size()), motion_.residual.cols());
      for (std::size_t k = 0; k < directions.size(); ++k)
        rows.row(static_cast<Eigen::Index>(k)) =
            directions[k].transpose() * motion_.residual.middleRows<3>(3 * static_cast<Eigen::Index>(i));
      Length length = along_itself(rows, tolerance);
      if (!(length->value <= worst->value)) worst = std::move(length);
    }
    return worst;
  }

  void fill_corners(PanelDeviationT& out) const {
    out.corner = unknown();
    for (const auto& [name, right, up] : {std::tuple{"bottom_left", low.x(), low.y()},
                                          {"bottom_right", high.x(), low.y()},
                                          {"top_left", low.x(), high.y()},
                                          {"top_right", high.x(), high.y()}}) {
      auto corner = std::make_unique<PanelCornerT>();
      corner->name = name;
      corner->design = at(right, up, high.z());
      corner->movement.setConstant(nan);
      Eigen::Vector3d moved = Eigen::Vector3d::Zero();
      for (const Eigen::Vector3d& direction : {axes_.right, axes_.up, axes_.out}) {
        const Row row = movement(corner->design, direction);
        moved += (row.size() == 0 ? nan : row.dot(part_.difference)) * direction;
      }
      if (moved.allFinite()) corner->movement = moved;
      if (const Row row = movement(corner->design, axes_.out); row.size() != 0) {
        Length length = judge(row, outward_);
        if (!(std::abs(length->value) <= std::abs(out.corner->value))) out.corner = std::move(length);
      }
      out.corners.push_back(std::move(corner));
    }
  }

  const PanelCase& panel_;
  evaluate::DifferenceSet part_;
  Axes axes_;
  double guard_factor_;
  std::vector<Eigen::Vector3d> fixings_;
  Eigen::Vector3d centre_;
  PanelMotion motion_;
  double vertical_ = nan, sideways_ = nan, outward_ = nan, in_plane_ = nan, joint_ = nan;
};

void fill_fixings(const PanelCase& panel, const DeviationInputs& inputs,
                  const std::vector<std::unique_ptr<AnchorDeviationT>>& judged, const Axes& axes,
                  PanelDeviationT& out) {
  for (const std::size_t anchor : panel.anchors) {
    const AnchorDeviationT& verdict = *judged[anchor];
    if (!verdict.deviation.allFinite()) {
      out.missing.push_back(verdict.id);
      continue;
    }
    auto fixing = std::make_unique<PanelFixingT>();
    fixing->anchor = verdict.id, fixing->guid = verdict.guid;
    fixing->shim = -axes.out.dot(verdict.deviation);
    fixing->sideways = -axes.right.dot(verdict.deviation), fixing->upward = -verdict.deviation.z();
    if (verdict.covariance.size() == 9) {
      const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> s(verdict.covariance.data());
      fixing->u_shim = std::sqrt(std::max(0.0, axes.out.dot(s * axes.out)));
    }
    const int floor = inputs.anchors[anchor].floor;
    if (floor > 0) out.floor = out.floor == 0 ? floor : std::min(out.floor, floor);
    out.fixings.push_back(std::move(fixing));
  }
}

/// The gap between two panels where `from` ends and `to` begins along axis 0 (right) or 1 (up).
struct Gap {
  int axis;
  double width, begin, end;  ///< [m]; begin and end along the other axis
};

/// Whether `b` follows `a` along the axis as a neighbour in one facade plane.
bool follows(const Panel& a, const Panel& b, int axis, Gap& gap) {
  const int other = 1 - axis;
  const double width = b.low[axis] - a.high[axis];
  if (width < -0.02 || width > kWidestJoint) return false;
  if (std::abs((b.low.z() + b.high.z()) - (a.low.z() + a.high.z())) > 0.2) return false;
  const double begin = std::max(a.low[other], b.low[other]), end = std::min(a.high[other], b.high[other]);
  const double shorter = std::min(a.high[other] - a.low[other], b.high[other] - b.low[other]);
  if (end - begin < 0.5 * shorter || end - begin < 0.05) return false;
  gap = {axis, width, begin, end};
  return true;
}

/// Change of the gap at one end with its uncertainty: movement of `b` minus movement of `a`, whose anchors may be
/// shared.
bool change_at(const Panel& a, const Panel& b, const Gap& gap, double place, const evaluate::DifferenceSet& all,
               const std::map<std::size_t, std::size_t>& position, double& value, double& u) {
  const Eigen::Vector3d direction = gap.axis == 0 ? a.axes().right : a.axes().up;
  const double face = 0.5 * (a.low.z() + a.high.z());
  const auto point = [&](double along) { return gap.axis == 0 ? a.at(along, place, face) : a.at(place, along, face); };
  const Row of_a = a.movement(point(a.high[gap.axis]), direction), of_b = b.movement(point(b.low[gap.axis]), direction);
  if (of_a.size() == 0 || of_b.size() == 0) return false;
  std::map<std::size_t, Eigen::RowVector3d> rows;  // by anchor
  const auto add = [&](const Panel& panel, const Row& row, double sign) {
    for (std::size_t i = 0; i < panel.part().size(); ++i) {
      auto& entry = rows.try_emplace(panel.part().anchors[i], Eigen::RowVector3d::Zero()).first->second;
      entry += sign * row.segment<3>(3 * static_cast<Eigen::Index>(i));
    }
  };
  add(b, of_b, 1), add(a, of_a, -1);
  value = of_b.dot(b.part().difference) - of_a.dot(a.part().difference);
  u = nan;
  if (all.covariance.size() == 0) return true;
  double variance = 0;
  for (const auto& [i, row_i] : rows)
    for (const auto& [j, row_j] : rows)
      variance += row_i *
                  all.covariance.block<3, 3>(3 * static_cast<Eigen::Index>(position.at(i)),
                                             3 * static_cast<Eigen::Index>(position.at(j))) *
                  row_j.transpose();
  u = std::sqrt(std::max(0.0, variance));
  return true;
}

class Joints {
 public:
  Joints(const std::vector<Panel>& panels, std::vector<std::unique_ptr<PanelDeviationT>>& out,
         const evaluate::DifferenceSet& all, double guard_factor)
      : panels_(panels), out_(out), all_(all), guard_factor_(guard_factor) {
    for (std::size_t i = 0; i < all.size(); ++i) position_[all.anchors[i]] = i;
  }

  void find() {
    for (std::size_t a = 0; a < panels_.size(); ++a)
      for (std::size_t b = 0; b < panels_.size(); ++b)
        for (int axis = 0; a != b && axis < 2; ++axis)
          if (Gap gap; follows(panels_[a], panels_[b], axis, gap)) add(a, b, gap);
  }

 private:
  void add(std::size_t a, std::size_t b, const Gap& gap) {
    double value[2], u[2];
    if (!change_at(panels_[a], panels_[b], gap, gap.begin, all_, position_, value[0], u[0])) return;
    if (!change_at(panels_[a], panels_[b], gap, gap.end, all_, position_, value[1], u[1])) return;
    const int worse = std::abs(value[1]) > std::abs(value[0]);
    const double width = std::max(0.0, gap.width);
    for (const auto& [own, other, side] :
         {std::tuple{a, b, gap.axis == 0 ? "right" : "above"}, {b, a, gap.axis == 0 ? "left" : "below"}}) {
      auto joint = std::make_unique<PanelJointT>();
      joint->panel = panels_[other].panel().guid, joint->name = panels_[other].panel().name, joint->side = side;
      joint->design = width;
      joint->narrowest = width + std::min(value[0], value[1]), joint->widest = width + std::max(value[0], value[1]);
      joint->change = std::make_unique<JudgedLengthT>();
      joint->change->value = value[worse], joint->change->u = u[worse];
      joint->change->tolerance = panels_[own].joint_tolerance();
      if (joint->change->tolerance > 0)
        joint->change->verdict = evaluate::verdict_of(value[worse], u[worse], joint->change->tolerance, guard_factor_);
      out_[own]->joints.push_back(std::move(joint));
    }
  }

  const std::vector<Panel>& panels_;
  std::vector<std::unique_ptr<PanelDeviationT>>& out_;
  const evaluate::DifferenceSet& all_;
  double guard_factor_;
  std::map<std::size_t, std::size_t> position_;
};

std::string length_words(const std::string& what, const JudgedLengthT& length) {
  char text[160];
  std::snprintf(text, sizeof text, "%s %.1f mm (limit %.3g mm)", what.c_str(), 1e3 * length.value,
                1e3 * length.tolerance);
  return text;
}

/// The worst decides; of equal verdicts that which uses most of its tolerance.
class Decision {
 public:
  explicit Decision(PanelDeviationT& out) : out_(out) {}
  void consider(const char* by, ToleranceVerdict verdict, double usage, const std::string& reason) {
    if (verdict == ToleranceVerdict::not_measured || verdict < out_.verdict) return;
    if (verdict == out_.verdict && !(usage > usage_)) return;
    out_.verdict = verdict, out_.decided_by = by, out_.reason = reason, usage_ = usage;
  }
  void consider(const char* by, const char* words, const JudgedLengthT& length) {
    if (std::isfinite(length.value))
      consider(by, length.verdict, std::abs(length.value) / length.tolerance, length_words(words, length));
  }

 private:
  PanelDeviationT& out_;
  double usage_ = -1;
};

void decide(PanelDeviationT& out, const std::map<std::string, const AnchorDeviationT*>& anchors) {
  Decision decision(out);
  decision.consider("out_of_plane", "out of plane", *out.out_of_plane);
  decision.consider("sideways", "sideways", *out.sideways);
  decision.consider("vertical", "height", *out.vertical);
  decision.consider("tilt", "tilt at an anchor", *out.tilt);
  decision.consider("warp", "warp", *out.warp);
  decision.consider("misfit", "slots of the anchors", *out.misfit);
  decision.consider("corner", "corner out of plane", *out.corner);
  for (const auto& joint : out.joints)
    decision.consider("joint", ("joint to " + (joint->name.empty() ? joint->panel : joint->name)).c_str(),
                      *joint->change);
  for (const auto& fixing : out.fixings) {
    const AnchorDeviationT& anchor = *anchors.at(fixing->anchor);
    double usage = 0;
    std::string words;
    for (const auto& axis : anchor.axes)
      if (axis->axis == anchor.decided_by)
        usage = std::abs(axis->value) / axis->tolerance,
        words = length_words("anchor " + anchor.id + " " + axis->axis, [&] {
          JudgedLengthT length;
          length.value = axis->value, length.tolerance = axis->tolerance;
          return length;
        }());
    if (anchor.verdict > ToleranceVerdict::pass) decision.consider("anchor", anchor.verdict, usage, words);
  }
  if (!out.missing.empty() && out.verdict < ToleranceVerdict::undecided)
    out.verdict = ToleranceVerdict::undecided, out.decided_by = "missing_anchor",
    out.reason = "anchor " + out.missing.front() + " was not measured";
}

}  // namespace

std::vector<std::unique_ptr<PanelDeviationT>> judge_panels(const DeviationInputs& inputs,
                                                           const evaluate::DifferenceSet& deviations,
                                                           const std::vector<std::unique_ptr<AnchorDeviationT>>& judged,
                                                           const DeviationOptions& options) {
  std::vector<std::unique_ptr<PanelDeviationT>> result;
  if (!inputs.facade_normal.allFinite()) return result;
  std::map<std::size_t, std::size_t> position;
  for (std::size_t i = 0; i < deviations.size(); ++i) position[deviations.anchors[i]] = i;
  std::vector<Panel> panels;
  panels.reserve(inputs.panels.size());
  for (const PanelCase& panel : inputs.panels) {
    std::vector<std::size_t> own;
    for (const std::size_t anchor : panel.anchors)
      if (const auto found = position.find(anchor); found != position.end()) own.push_back(found->second);
    if (own.empty()) continue;
    panels.emplace_back(panel, inputs, deviations.subset(own), options);
    auto out = std::make_unique<PanelDeviationT>();
    out->guid = panel.guid, out->name = panel.name, out->instance = panel.instance;
    out->storey_guid = panel.storey_guid;
    fill_fixings(panel, inputs, judged, panels.back().axes(), *out);
    panels.back().fill(*out);
    result.push_back(std::move(out));
  }
  Joints(panels, result, deviations, options.guard_factor).find();
  std::map<std::string, const AnchorDeviationT*> anchors;
  for (const auto& anchor : judged) anchors[anchor->id] = anchor.get();
  for (auto& panel : result) decide(*panel, anchors);
  return result;
}

}  // namespace plumbline::judgement

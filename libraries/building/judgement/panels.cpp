#include "building/judgement/panels.hpp"

#include <fmt/core.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <tuple>

#include "building/ifc/facade_artifact.hpp"
#include "building/judgement/conformance.hpp"
#include "building/judgement/figures.hpp"
#include "geometry/panel_fit.hpp"

namespace plumbline::judgement {
namespace {

using Row = Eigen::RowVectorXd;
using Length = std::unique_ptr<JudgedLengthT>;

/// Panels farther apart than this are no neighbours [m].
constexpr double kWidestJoint = 0.2;

using Axes = ifc::FacadeFrame;
/// Panels that face more differently than this share no joint: at a corner they meet in an edge.
const double kOneFacade = std::cos(20 * std::numbers::pi / 180);

/// Not judged where no tolerance is given: its value is nan then.
Tolerance tolerance_for(const Tolerances& tolerances, Axis axis, const Tolerance& fallback = {}) {
  const auto found = tolerances.find(axis);
  return found == tolerances.end() ? fallback : found->second;
}

/// Of a length that says nothing of a position (a turn, a warp): half of what lies between the two sides, on either.
Tolerance about_zero(Tolerance tolerance) {
  tolerance.value = 0.5 * (tolerance.value + tolerance.lower()), tolerance.below = nan;
  return tolerance;
}

/// A panel on its anchors: every length is a row that acts on the deviations of `part`.
class Panel {
 public:
  Panel(const PanelCase& panel, const DeviationInputs& inputs, const judgement::DifferenceSet& part,
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
    for (Length* length :
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

  const judgement::DifferenceSet& part() const { return part_; }
  const PanelCase& panel() const { return panel_; }
  const Axes& axes() const { return axes_; }
  const Tolerance& joint_tolerance() const { return joint_; }
  /// Too far from another for any joint: cheap, because every two panels are asked.
  bool far_from(const Panel& other) const {
    return (centre_ - other.centre_).norm() > reach() + other.reach() + kWidestJoint;
  }
  const Eigen::Vector3d& centre() const { return centre_; }
  double reach() const { return 0.5 * (panel_.high - panel_.low).norm(); }
  /// Its box along right, up and out.
  Eigen::Vector3d low, high;
  /// The same along those of another.
  std::pair<Eigen::Vector3d, Eigen::Vector3d> box_in(const Axes& axes) const {
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

  double uncertainty(const Row& row) const {
    if (covariance_.size() == 0) return nan;
    return std::sqrt(std::max(0.0, (row * covariance_ * row.transpose()).value()));
  }
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
      shown.u = uncertainty(one || !(value > 0) ? Row(rows.row(0)) : Row(vector.normalized().transpose() * rows));
      shown.tolerance = one ? tolerance.limit_of(value) : about_zero(tolerance).value;
    }
    if (std::isnan(tolerance.value)) return;
    if (!level && skipped(tolerance)) {
      shown.tolerance = nan, left_out_ = true;
      return;
    }
    const double above = one ? tolerance.value : about_zero(tolerance).value;
    limits_.push_back({rows, above, tolerance.lower(), tolerance.source.starts_with("default")});
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
      for (const Eigen::Vector3d& direction : {axes_.right, axes_.up, axes_.out}) {
        const Row row = movement(corner->design, direction);
        moved += (row.size() == 0 ? nan : row.dot(part_.difference)) * direction;
      }
      if (moved.allFinite()) corner->movement = moved;
      if (const Row row = movement(corner->design, axes_.out); row.size() != 0) judge(*out.corner, row, outward_);
      out.corners.push_back(std::move(corner));
    }
  }

  const PanelCase& panel_;
  judgement::DifferenceSet part_;
  Eigen::MatrixXd covariance_;
  Axes axes_;
  const DeviationOptions& options_;
  std::vector<Limited> limits_;  // what it is held against, and where each is shown
  std::vector<JudgedLengthT*> lengths_;
  std::vector<Eigen::Vector3d> fixings_;
  Eigen::Vector3d centre_;
  PanelMotion motion_;
  Tolerance vertical_, sideways_, outward_, out_of_place_, in_plane_, joint_;
  bool skip_out_ = false, skip_along_ = false, left_out_ = false;
};

void fill_fixings(const PanelCase& panel, const DeviationInputs& inputs,
                  const std::vector<std::unique_ptr<AnchorDeviationT>>& judged, const Axes& axes,
                  PanelDeviationT& out) {
  // An order that may be the wrong way round is none.
  const double order = axes.confirmed ? 1 : nan;
  for (const std::size_t anchor : panel.anchors) {
    const AnchorDeviationT& verdict = *judged[anchor];
    if (!verdict.deviation.allFinite()) {
      out.missing.push_back(verdict.id);
      continue;
    }
    auto fixing = std::make_unique<PanelFixingT>();
    fixing->anchor = verdict.id, fixing->guid = verdict.guid;
    fixing->shim = -order * axes.out.dot(verdict.deviation);
    fixing->sideways = -order * axes.right.dot(verdict.deviation);
    fixing->upward = -axes.up.dot(verdict.deviation);
    if (verdict.covariance.size() == 9) {
      const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> s(verdict.covariance.data());
      fixing->u_shim = std::sqrt(std::max(0.0, axes.out.dot(s * axes.out)));
    }
    const int floor = inputs.anchors[anchor].floor;
    if (floor > 0) out.floor = out.floor == 0 ? floor : std::min(out.floor, floor);
    out.fixings.push_back(std::move(fixing));
  }
}

void fill_limits(const Tolerances& tolerances, PanelDeviationT& out) {
  for (const auto& [axis, tolerance] : tolerances) {
    auto limit = std::make_unique<PanelLimitT>();
    limit->axis = name_of(axis), limit->above = tolerance.value, limit->below = tolerance.lower();
    limit->source = tolerance.source;
    out.limits.push_back(std::move(limit));
  }
}

/// A panel that faces nowhere that is known is not left out: it is listed, and undecided.
void fill_unknown(PanelDeviationT& out) {
  out.shift.setConstant(nan), out.rotation.setConstant(nan);
  for (Length* length :
       {&out.out_of_plane, &out.sideways, &out.vertical, &out.tilt, &out.warp, &out.misfit, &out.corner})
    *length = std::make_unique<JudgedLengthT>();
}

/// The gap between two panels where `from` ends and `to` begins along axis 0 (right) or 1 (up) of `from`.
struct Gap {
  int axis;
  double from, to, begin, end;  ///< [m]; begin and end along the other axis
  double width() const { return to - from; }
};

/// Whether `b` follows `a` along the axis as a neighbour on one facade, which may bend a little between them.
bool follows(const Panel& a, const Panel& b, int axis, Gap& gap) {
  const double turn = a.axes().out.dot(b.axes().out);
  if (turn < kOneFacade) return false;
  const int other = 1 - axis;
  const auto [low, high] = b.box_in(a.axes());
  const double width = low[axis] - a.high[axis];
  if (width < -0.02 || width > kWidestJoint) return false;
  const double bend = std::tan(std::acos(std::min(1.0, turn)));
  const double middles = std::abs((low.z() + high.z()) - (a.low.z() + a.high.z()));
  if (middles > 0.2 + bend * (high[axis] - a.low[axis])) return false;
  const double begin = std::max(a.low[other], low[other]), end = std::min(a.high[other], high[other]);
  const double shorter = std::min(a.high[other] - a.low[other], high[other] - low[other]);
  if (end - begin < 0.5 * shorter || end - begin < 0.05) return false;
  gap = {axis, a.high[axis], low[axis], begin, end};
  return true;
}

/// Change of the gap at one end with its uncertainty: movement of `b` minus movement of `a`, whose anchors may be
/// shared.
bool change_at(const Panel& a, const Panel& b, const Gap& gap, double place, const judgement::DifferenceSet& all,
               const std::map<std::size_t, std::size_t>& position, double& value, double& u) {
  const Eigen::Vector3d direction = gap.axis == 0 ? a.axes().right : a.axes().up;
  const double face = 0.5 * (a.low.z() + a.high.z());
  const auto point = [&](double along) { return gap.axis == 0 ? a.at(along, place, face) : a.at(place, along, face); };
  const Row of_a = a.movement(point(gap.from), direction), of_b = b.movement(point(gap.to), direction);
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
      variance +=
          row_i *
          all.covariance.block(static_cast<Eigen::Index>(position.at(i)), static_cast<Eigen::Index>(position.at(j))) *
          row_j.transpose();
  u = std::sqrt(std::max(0.0, variance));
  return true;
}

class Joints {
 public:
  Joints(const std::vector<Panel>& panels, std::vector<std::unique_ptr<PanelDeviationT>>& out,
         const judgement::DifferenceSet& all, const DeviationOptions& options)
      : panels_(panels), out_(out), all_(all), options_(options) {
    for (std::size_t i = 0; i < all.size(); ++i) position_[all.anchors[i]] = i;
  }

  void find() {
    double reach = 0;
    for (const Panel& panel : panels_) reach = std::max(reach, panel.reach());
    const double size = 2 * reach + kWidestJoint;  // of a cell: what touches a panel is in one of those around its own
    const auto cell = [&](const Panel& panel, int k) { return static_cast<int>(std::floor(panel.centre()[k] / size)); };
    std::map<std::array<int, 3>, std::vector<std::size_t>> cells;
    for (std::size_t i = 0; i < panels_.size(); ++i)
      cells[{cell(panels_[i], 0), cell(panels_[i], 1), cell(panels_[i], 2)}].push_back(i);
    for (std::size_t a = 0; a < panels_.size(); ++a) {
      std::vector<std::size_t> near;
      for (int x = -1; x <= 1; ++x)
        for (int y = -1; y <= 1; ++y)
          for (int z = -1; z <= 1; ++z)
            if (const auto found =
                    cells.find({cell(panels_[a], 0) + x, cell(panels_[a], 1) + y, cell(panels_[a], 2) + z});
                found != cells.end())
              near.insert(near.end(), found->second.begin(), found->second.end());
      std::sort(near.begin(), near.end());
      for (const std::size_t b : near)
        for (int axis = 0; a != b && !panels_[a].far_from(panels_[b]) && axis < 2; ++axis)
          if (Gap gap; follows(panels_[a], panels_[b], axis, gap)) add(a, b, gap);
    }
  }

 private:
  void add(std::size_t a, std::size_t b, const Gap& gap) {
    double value[2], u[2];
    if (!change_at(panels_[a], panels_[b], gap, gap.begin, all_, position_, value[0], u[0])) return;
    if (!change_at(panels_[a], panels_[b], gap, gap.end, all_, position_, value[1], u[1])) return;
    const int worse = std::abs(value[1]) > std::abs(value[0]);
    const double width = std::max(0.0, gap.width());
    for (const auto& [own, other, side] :
         {std::tuple{a, b, gap.axis == 0 ? "right" : "above"}, {b, a, gap.axis == 0 ? "left" : "below"}}) {
      auto joint = std::make_unique<PanelJointT>();
      joint->panel = panels_[other].panel().guid, joint->name = panels_[other].panel().name, joint->side = side;
      joint->design = width;
      joint->narrowest = width + std::min(value[0], value[1]), joint->widest = width + std::max(value[0], value[1]);
      joint->change = std::make_unique<JudgedLengthT>();
      joint->change->value = value[worse], joint->change->u = u[worse];
      const Tolerance& tolerance = panels_[own].joint_tolerance();
      joint->change->tolerance = tolerance.limit_of(value[worse]);
      judge(*joint->change, tolerance, *out_[own]);
      out_[own]->joints.push_back(std::move(joint));
    }
  }

  /// The panel turns with its joints too.
  void judge(JudgedLengthT& change, const Tolerance& tolerance, PanelDeviationT& panel) const {
    if (std::isnan(tolerance.value)) return;
    const Limited limited{Eigen::MatrixXd::Ones(1, 1), tolerance.value, tolerance.lower(),
                          tolerance.source.starts_with("default")};
    const Eigen::MatrixXd variance =
        std::isnan(change.u) ? Eigen::MatrixXd() : Eigen::MatrixXd::Constant(1, 1, change.u * change.u);
    const Conformance found =
        conformance(Eigen::VectorXd::Constant(1, change.value), variance, {limited}, options_.risk, options_.tau);
    change.verdict = verdict_of(found.probability, options_.risk);
    panel.tau_pass = std::max(panel.tau_pass, found.tau_pass),
    panel.tau_fail = std::max(panel.tau_fail, found.tau_fail);
  }

  const std::vector<Panel>& panels_;
  std::vector<std::unique_ptr<PanelDeviationT>>& out_;
  const judgement::DifferenceSet& all_;
  const DeviationOptions& options_;
  std::map<std::size_t, std::size_t> position_;
};

std::string length_words(const std::string& what, const JudgedLengthT& length) {
  return fmt::format("{} {:.1f} mm (limit {:.3g} mm)", what, 1e3 * length.value, 1e3 * length.tolerance);
}

/// Share of a tolerance that a value uses; 0 where there is none.
double share_of(double value, double tolerance) {
  const double share = std::abs(value) / tolerance;
  return std::isnan(share) ? 0 : share;
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
      consider(by, length.verdict, share_of(length.value, length.tolerance), length_words(words, length));
  }

 private:
  PanelDeviationT& out_;
  double usage_ = -1;
};

void decide(PanelDeviationT& out, const std::map<std::string, const AnchorDeviationT*>& anchors) {
  // All its lengths at once, and the one that speaks for it.
  const ToleranceVerdict together = out.verdict;
  out.verdict = ToleranceVerdict::not_measured;
  Decision decision(out);
  decision.consider("out_of_plane", "out of plane", *out.out_of_plane);
  decision.consider("sideways", "sideways", *out.sideways);
  decision.consider("vertical", "height", *out.vertical);
  decision.consider("tilt", "tilt at an anchor", *out.tilt);
  decision.consider("warp", "warp", *out.warp);
  decision.consider("misfit", "slots of the anchors", *out.misfit);
  decision.consider("corner", "corner out of plane", *out.corner);
  if (together != ToleranceVerdict::not_measured) out.verdict = std::max(out.verdict, together);
  for (const auto& joint : out.joints)
    decision.consider("joint", ("joint to " + (joint->name.empty() ? joint->panel : joint->name)).c_str(),
                      *joint->change);
  for (const auto& fixing : out.fixings) {
    const AnchorDeviationT& anchor = *anchors.at(fixing->anchor);
    double usage = 0;
    std::string words;
    for (const auto& axis : anchor.axes)
      if (axis->axis == anchor.decided_by)
        usage = share_of(axis->value, axis->tolerance),
        words = length_words("anchor " + anchor.id + " " + axis->axis, [&] {
          JudgedLengthT length;
          length.value = axis->value, length.tolerance = axis->tolerance;
          return length;
        }());
    if (words.empty()) words = "anchor " + anchor.id + (anchor.note.empty() ? " is not decided" : ": " + anchor.note);
    if (anchor.verdict > ToleranceVerdict::pass) decision.consider("anchor", anchor.verdict, usage, words);
  }
  const bool confirmed = out.facade && out.facade->confirmed;
  if (!confirmed && out.verdict < ToleranceVerdict::undecided)
    out.verdict = ToleranceVerdict::undecided, out.decided_by = "facade",
    out.reason = out.facade && out.facade->out.allFinite() ? "not decided: " + out.facade->note
                                                           : "not judged: nothing says which way it faces";
  if (!out.missing.empty() && out.verdict < ToleranceVerdict::undecided)
    out.verdict = ToleranceVerdict::undecided, out.decided_by = "missing_anchor",
    out.reason = "anchor " + out.missing.front() + " was not measured";
  if (!out.missing.empty()) out.tau_pass = std::numeric_limits<double>::infinity();
}

}  // namespace

std::vector<std::unique_ptr<PanelDeviationT>> judge_panels(const DeviationInputs& inputs,
                                                           const judgement::DifferenceSet& deviations,
                                                           const std::vector<std::unique_ptr<AnchorDeviationT>>& judged,
                                                           const DeviationOptions& options) {
  std::vector<std::unique_ptr<PanelDeviationT>> result;
  std::map<std::size_t, std::size_t> position;
  for (std::size_t i = 0; i < deviations.size(); ++i) position[deviations.anchors[i]] = i;
  std::vector<std::unique_ptr<PanelDeviationT>> nowhere;  // face nowhere that is known
  std::vector<Panel> panels;
  panels.reserve(inputs.panels.size());
  for (const PanelCase& panel : inputs.panels) {
    std::vector<std::size_t> own;
    for (const std::size_t anchor : panel.anchors)
      if (const auto found = position.find(anchor); found != position.end()) own.push_back(found->second);
    if (own.empty()) continue;
    auto out = std::make_unique<PanelDeviationT>();
    out->guid = panel.guid, out->name = panel.name, out->instance = panel.instance;
    out->storey_guid = panel.storey_guid, out->facade = ifc::to_artifact(panel.facade);
    fill_limits(panel.tolerances, *out);
    fill_fixings(panel, inputs, judged, panel.facade, *out);
    if (panel.facade.known()) {
      panels.emplace_back(panel, inputs, deviations.subset(own), options);
      panels.back().fill(*out);
      result.push_back(std::move(out));
    } else {
      fill_unknown(*out);
      nowhere.push_back(std::move(out));
    }
  }
  Joints(panels, result, deviations, options).find();
  for (auto& panel : nowhere) result.push_back(std::move(panel));
  std::map<std::string, const AnchorDeviationT*> anchors;
  for (const auto& anchor : judged) anchors[anchor->id] = anchor.get();
  for (auto& panel : result) decide(*panel, anchors);
  return result;
}

}  // namespace plumbline::judgement

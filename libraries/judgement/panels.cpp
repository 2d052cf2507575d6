#include "judgement/panels.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/panel_fit.hpp"
#include "judgement/tolerance.hpp"
#include "plumbline/rigid_transform.hpp"

namespace plumbline::evaluate {

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// Axes of one who stands before the facade.
struct Axes {
  Eigen::Vector3d up = Eigen::Vector3d::UnitZ(), out, right;
  explicit Axes(const Eigen::Vector3d& outward)
      : out(Eigen::Vector3d(outward.x(), outward.y(), 0).normalized()), right(up.cross(out)) {}
};

class Panel {
 public:
  Panel(const PanelEntry& entry, const std::vector<Eigen::Vector3d>& fixings, const DifferenceSet& deviations,
        const Options& options)
      : axes_(entry.outward),
        centre_(entry.centre),
        fixings_(fixings),
        motion_(fit_panel(fixings, entry.centre)),
        deviations_(deviations),
        options_(options) {}

  void fill(PanelAccuracyT& out) const {
    out.out_of_plane = judge(translation(axes_.out));
    out.sideways = judge(translation(axes_.right));
    out.vertical = judge(translation(axes_.up));
    angle(axes_.right, 1, out.lean, out.u_lean);
    angle(axes_.up, -1, out.turn, out.u_turn);  // right × out points down
    angle(axes_.out, 1, out.roll, out.u_roll);
    out.tilt = tilt();
    out.warp = motion_.rotations == 3 && fixings_.size() > 3 ? worst_residual({axes_.out}) : unknown();
    out.misfit = fixings_.size() > 1 ? worst_residual({axes_.right, axes_.up}) : unknown();
    decide(out);
  }

 private:
  using Row = Eigen::RowVectorXd;
  using Length = std::unique_ptr<JudgedLengthT>;

  double value(const Row& row) const { return row.dot(deviations_.difference); }
  double uncertainty(const Row& row) const {
    if (deviations_.covariance.size() == 0) return nan;
    return std::sqrt(std::max(0.0, (row * deviations_.covariance * row.transpose()).value()));
  }
  static Length unknown() { return std::make_unique<JudgedLengthT>(); }
  Length judge(const Row& row) const {
    Length length = unknown();
    length->value = value(row), length->u = uncertainty(row);
    length->verdict = verdict_of(length->value, length->u, options_.tau, options_.guard_factor);
    return length;
  }

  Row translation(const Eigen::Vector3d& direction) const { return direction.transpose() * motion_.pose.topRows<3>(); }

  /// Rotation about an axis; nan where the fixings stand in a line that is not square to it.
  void angle(const Eigen::Vector3d& axis, double sign, double& out, double& u) const {
    if (motion_.rotations == 0) return;
    if (motion_.rotations == 2) {
      Eigen::Vector3d line = Eigen::Vector3d::Zero();
      for (const Eigen::Vector3d& p : fixings_)
        if ((p - fixings_[0]).norm() > line.norm()) line = p - fixings_[0];
      if (std::abs(line.normalized().dot(axis)) > 0.05) return;
    }
    const Row row = sign * axis.transpose() * motion_.pose.bottomRows<3>();
    out = value(row), u = uncertainty(row);
  }

  /// The length of a vector that is linear in the deviations, judged along its own direction.
  Length along_itself(const Eigen::MatrixXd& rows) const {
    const Eigen::VectorXd vector = rows * deviations_.difference;
    if (!(vector.norm() > 0)) return judge(rows.row(0));
    return judge(vector.normalized().transpose() * rows);
  }

  Length tilt() const {
    if (motion_.rotations == 0) return unknown();
    Length worst = unknown();
    for (const Eigen::Vector3d& fixing : fixings_) {
      Length moved = along_itself(-skew(fixing - centre_) * motion_.pose.bottomRows<3>());
      if (!(moved->value <= worst->value)) worst = std::move(moved);
    }
    return worst;
  }

  /// Over all fixings, the largest part of the residual in the span of `directions`.
  Length worst_residual(const std::vector<Eigen::Vector3d>& directions) const {
    Length worst = unknown();
    for (std::size_t i = 0; i < fixings_.size(); ++i) {
      Eigen::MatrixXd rows(static_cast<Eigen::Index>(directions.size()), motion_.residual.cols());
      for (std::size_t k = 0; k < directions.size(); ++k)
        rows.row(static_cast<Eigen::Index>(k)) =
            directions[k].transpose() * motion_.residual.middleRows<3>(3 * static_cast<Eigen::Index>(i));
      Length length = along_itself(rows);
      if (!(length->value <= worst->value)) worst = std::move(length);
    }
    return worst;
  }

  static void decide(PanelAccuracyT& out) {
    const std::pair<const char*, const JudgedLengthT*> parts[] = {{"out_of_plane", out.out_of_plane.get()},
                                                                  {"sideways", out.sideways.get()},
                                                                  {"vertical", out.vertical.get()},
                                                                  {"tilt", out.tilt.get()},
                                                                  {"warp", out.warp.get()},
                                                                  {"misfit", out.misfit.get()}};
    double largest = -1;
    for (const auto& [name, part] : parts) {
      if (part->verdict < out.verdict || !std::isfinite(part->value)) continue;
      if (part->verdict == out.verdict && std::abs(part->value) <= largest) continue;
      out.verdict = part->verdict, out.decided_by = name, largest = std::abs(part->value);
    }
  }

  Axes axes_;
  Eigen::Vector3d centre_;
  const std::vector<Eigen::Vector3d>& fixings_;
  PanelMotion motion_;
  const DifferenceSet& deviations_;
  const Options& options_;
};

}  // namespace

std::vector<std::unique_ptr<PanelAccuracyT>> panel_accuracy(const DifferenceSet& deviations,
                                                            const std::vector<AnchorEntry>& table,
                                                            const PointSet& design,
                                                            const std::vector<PanelEntry>& panels,
                                                            const Options& options) {
  const std::map<std::string, std::size_t> place = index_points(design, "design");
  std::map<std::string, std::size_t> measured;
  for (std::size_t i = 0; i < deviations.size(); ++i) measured[table[deviations.anchors[i]].id] = i;
  std::vector<std::unique_ptr<PanelAccuracyT>> result;
  for (const PanelEntry& panel : panels) {
    auto out = std::make_unique<PanelAccuracyT>();
    out->guid = panel.guid, out->name = panel.name;
    out->anchors_listed = static_cast<int>(panel.anchors.size());
    std::vector<std::size_t> positions;
    std::vector<Eigen::Vector3d> fixings;
    for (const std::string& id : panel.anchors) {
      const auto found = measured.find(id);
      if (found == measured.end()) continue;
      positions.push_back(found->second);
      fixings.push_back(design.positions[place.at(id)]);
      out->anchors.push_back(id);
      const int floor = table[deviations.anchors[found->second]].floor;
      if (floor > 0) out->floor = out->floor == 0 ? floor : std::min(out->floor, floor);
    }
    if (positions.empty()) continue;
    const DifferenceSet part = deviations.subset(positions);
    Panel(panel, fixings, part, options).fill(*out);
    result.push_back(std::move(out));
  }
  return result;
}

}  // namespace plumbline::evaluate

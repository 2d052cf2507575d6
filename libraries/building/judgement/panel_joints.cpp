#include "building/judgement/panel_joints.hpp"

#include <array>
#include <map>

#include "building/ifc/tolerance_source.hpp"

namespace plumbline::judgement {
namespace {

/// The gap between two panels where `from` ends and `to` begins along axis 0 (right) or 1 (up) of `from`.
struct Gap {
  int axis;
  double from, to, begin, end;  ///< [m]; begin and end along the other axis
};

/// As of surfaces: between the outer sides of both, behind which bodies may reach further [m].
double width_of(const JudgedPanel& a, const JudgedPanel& b, const Gap& gap) {
  return std::max(0.0, b.side_in(a.axes()).first[gap.axis] - a.side_in(a.axes()).second[gap.axis]);
}

/// Whether `b` follows `a` along the axis as a neighbour on one facade, which may bend a little between them.
bool follows(const JudgedPanel& a, const JudgedPanel& b, int axis, Gap& gap) {
  const double turn = a.axes().out.dot(b.axes().out);
  if (turn < kOneFacade) return false;
  const int other = 1 - axis;
  const auto [low, high] = b.box_in(a.axes());
  const double width = low[axis] - a.high[axis];
  if (width < -0.02 || width > kWidestJoint) return false;
  const double middles = std::abs((low.z() + high.z()) - (a.low.z() + a.high.z()));
  if (middles > most_set_back(turn, high[axis] - a.low[axis])) return false;
  const double begin = std::max(a.low[other], low[other]), end = std::min(a.high[other], high[other]);
  const double shorter = std::min(a.high[other] - a.low[other], high[other] - low[other]);
  if (end - begin < 0.5 * shorter || end - begin < 0.05) return false;
  gap = {axis, a.high[axis], low[axis], begin, end};
  return true;
}

/// Change of the gap at one end with its uncertainty: movement of `b` minus movement of `a`, whose anchors may be
/// shared.
bool change_at(const JudgedPanel& a, const JudgedPanel& b, const Gap& gap, double place, const LengthBasis& basis,
               double& value, double& u) {
  const Eigen::Vector3d direction = gap.axis == 0 ? a.axes().right : a.axes().up;
  const double face = 0.5 * (a.low.z() + a.high.z());
  const auto point = [&](double along) { return gap.axis == 0 ? a.at(along, place, face) : a.at(place, along, face); };
  const Eigen::RowVectorXd of_a = a.movement(point(gap.from), direction), of_b = b.movement(point(gap.to), direction);
  if (of_a.size() == 0 || of_b.size() == 0) return false;
  LinearLength change = b.in_full(of_b);
  change.add(a.in_full(of_a), -1);
  value = b.value(of_b) - a.value(of_a);
  const double variance = basis.covariance(change, change);
  u = std::isnan(variance) ? nan : std::sqrt(std::max(0.0, variance));
  return true;
}

class Joints {
 public:
  Joints(const std::vector<JudgedPanel>& panels, std::vector<std::unique_ptr<PanelDeviationT>>& out,
         const LengthBasis& basis, const DeviationOptions& options)
      : panels_(panels), out_(out), basis_(basis), options_(options) {}

  void find() {
    double reach = 0;
    for (const JudgedPanel& panel : panels_) reach = std::max(reach, panel.reach());
    const double size = 2 * reach + kWidestJoint;  // of a cell: what touches a panel is in one of those around its own
    const auto cell = [&](const JudgedPanel& panel, int k) {
      return static_cast<int>(std::floor(panel.centre()[k] / size));
    };
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
    if (!change_at(panels_[a], panels_[b], gap, gap.begin, basis_, value[0], u[0])) return;
    if (!change_at(panels_[a], panels_[b], gap, gap.end, basis_, value[1], u[1])) return;
    const int worse = std::abs(value[1]) > std::abs(value[0]);
    const double width = width_of(panels_[a], panels_[b], gap);
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
                          ifc::is_default_tolerance(tolerance.source)};
    const Eigen::MatrixXd variance =
        std::isnan(change.u) ? Eigen::MatrixXd() : Eigen::MatrixXd::Constant(1, 1, change.u * change.u);
    const Conformance found =
        conformance(Eigen::VectorXd::Constant(1, change.value), variance, {limited}, options_.risk, options_.tau);
    change.verdict = verdict_of(found.probability, options_.risk);
    panel.pass_probability = least_known(panel.pass_probability, found.probability);
    panel.tau_pass = std::max(panel.tau_pass, found.tau_pass),
    panel.tau_fail = std::max(panel.tau_fail, found.tau_fail);
  }

  const std::vector<JudgedPanel>& panels_;
  std::vector<std::unique_ptr<PanelDeviationT>>& out_;
  const LengthBasis& basis_;
  const DeviationOptions& options_;
};

}  // namespace

void judge_joints(const std::vector<JudgedPanel>& panels, const LengthBasis& basis, const DeviationOptions& options,
                  std::vector<std::unique_ptr<PanelDeviationT>>& out) {
  Joints(panels, out, basis, options).find();
}

}  // namespace plumbline::judgement

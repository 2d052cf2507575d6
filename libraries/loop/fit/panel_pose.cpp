#include "loop/fit/panel_pose.hpp"

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <set>

#include "geometry/linear_algebra/decompositions.hpp"
#include "geometry/panel_fit.hpp"
#include "geometry/vectors.hpp"

namespace plumbline::loop {

Eigen::Matrix<double, 1, 6> PanelPose::movement(const Panel& panel, const Eigen::Vector3d& point,
                                                const Eigen::Vector3d& direction) const {
  Eigen::Matrix<double, 1, 6> row;
  row << direction.transpose(), (point - panel.centre).cross(direction).transpose() / arm;
  return row;
}

bool PanelPose::tells(const Eigen::Matrix<double, 1, 6>& row) const {
  if (open.cols() == 0) return true;
  const double moved = (row * open).norm();
  const double turn = open.cols() == 1 ? open.col(0).tail<3>().norm() : 0;  // [rad] times arm
  return moved < (turn > 0.5 ? kOpenArm * turn / arm : 0.05);
}

namespace {

/// Whether hooks tell a twist (unit length) that moves them by so much together: a turn by their arms off its line, as
/// the judgement has it (kTurnArm), anything else by a hundredth.
bool is_told(double moved, const Eigen::Matrix<double, 6, 1>& twist, double arm) {
  const double turn = twist.tail<3>().norm();
  return moved > (turn > 0.5 ? kTurnArm * turn / arm : 0.01);
}

}  // namespace

Eigen::Index PanelPose::own() const {
  if (!stand) return static_cast<Eigen::Index>(held.size());
  return std::count_if(held.begin(), held.end(), [](const Held& one) { return !one.is_below; });
}

PanelPose pose_of(const Panel& panel, const std::vector<Bracket>& brackets) {
  PanelPose pose;
  pose.arm = std::max(0.1, 0.5 * (panel.corners[3] - panel.corners[0]).norm());
  for (const Hook& hook : panel.hooks)
    for (int k = 0; k < 3; ++k)
      if (hook.holds[k] && brackets[hook.bracket].measured()) pose.held.push_back({hook.bracket, panel.axes.col(k)});
  const auto h = static_cast<Eigen::Index>(pose.held.size());
  pose.hooks.resize(h, 6), pose.solve.setZero(6, h), pose.open = Eigen::MatrixXd::Identity(6, 6);
  pose.strain.resize(h, 0);
  if (h == 0) return pose;
  for (Eigen::Index i = 0; i < h; ++i) {
    const PanelPose::Held& held = pose.held[i];
    pose.hooks.row(i) = pose.movement(panel, brackets[held.bracket].design, held.direction);
  }
  const linear_algebra::SingularValues svd(pose.hooks, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Index rank = 0;
  while (rank < svd.singularValues().size() && is_told(svd.singularValues()[rank], svd.matrixV().col(rank), pose.arm))
    ++rank;
  pose.solve = svd.matrixV().leftCols(rank) * svd.singularValues().head(rank).cwiseInverse().asDiagonal() *
               svd.matrixU().leftCols(rank).transpose();
  pose.open = svd.matrixV().rightCols(6 - rank);
  pose.strain = svd.matrixU().rightCols(h - rank);
  return pose;
}

namespace {

/// Parts of a movement that are nothing: of a high column the hooks far below have none in the uppermost panel.
constexpr double kNoPart = 1e-7;

class Stack {
 public:
  explicit Stack(const Facade& facade) : facade_(facade), asked_(facade.panels.size(), false) {
    for (const Panel& panel : facade.panels) poses_.push_back(pose_of(panel, facade.brackets));
  }

  std::vector<PanelPose> poses() {
    for (std::size_t j = 0; j < poses_.size(); ++j) close(j);
    return std::move(poses_);
  }

 private:
  void close(std::size_t j) {
    if (asked_[j]) return;  // depends_on has no circle, and who stands on another depends on it
    asked_[j] = true;
    const Panel& panel = facade_.panels[j];
    PanelPose& pose = poses_[j];
    if (!panel.below || pose.open.cols() != 1) return;
    const Support& below = *panel.below;
    const auto held = pose.movement(panel, below.place, panel.axes.col(2));
    const auto lift = lift_of(pose.open.col(0), pose.open.col(0).tail<3>().norm() / pose.arm, held);
    if (!lift) return;
    std::vector<PanelPose::Held> carrying;
    Eigen::RowVectorXd row;
    std::vector<std::pair<std::size_t, double>> seats{{j, 1.0}};
    if (!carried_by(below, panel.axes.col(2), carrying, row, seats)) return;
    const auto own = static_cast<Eigen::Index>(pose.held.size());
    const Eigen::MatrixXd told = pose.solve - *lift * (held * pose.solve);
    std::vector<Eigen::Index> kept;
    for (Eigen::Index i = 0; i < row.size(); ++i)
      if (std::abs(row[i]) * lift->norm() > kNoPart) kept.push_back(i);
    pose.solve.resize(6, own + static_cast<Eigen::Index>(kept.size()));
    pose.solve.leftCols(own) = told;
    for (std::size_t i = 0; i < kept.size(); ++i) {
      pose.solve.col(own + static_cast<Eigen::Index>(i)) = row[kept[i]] * *lift;
      pose.held.push_back(carrying[static_cast<std::size_t>(kept[i])]);
    }
    pose.strain.conservativeResize(pose.solve.cols(), pose.strain.cols());
    pose.strain.bottomRows(pose.solve.cols() - own).setZero();
    if (below.panel >= 0) {
      const auto carrier = static_cast<std::size_t>(below.panel);
      pose.stand = {carrier, poses_[carrier].movement(facade_.panels[carrier], below.place, panel.axes.col(2)), *lift};
    }
    pose.open.resize(6, 0);
    for (const auto& [seat, factor] : seats) pose.seats.emplace_back(seat, factor * *lift);
  }

  /// How far out the edge is held, as a row over the directions that hooks of the panel below hold, or the sill; false
  /// where that is not told.
  bool carried_by(const Support& below, const Eigen::Vector3d& out, std::vector<PanelPose::Held>& carrying,
                  Eigen::RowVectorXd& row, std::vector<std::pair<std::size_t, double>>& seats) {
    if (below.panel < 0) {
      row.resize(static_cast<Eigen::Index>(below.sills.size()));
      for (const auto& [sill, weight] : below.sills) {
        if (!facade_.brackets[sill].measured()) return false;
        row[static_cast<Eigen::Index>(carrying.size())] = weight;
        carrying.push_back({sill, out, true});
      }
      return true;
    }
    const auto carrier = static_cast<std::size_t>(below.panel);
    close(carrier);
    const PanelPose& pose = poses_[carrier];
    const auto edge = pose.movement(facade_.panels[carrier], below.place, out);
    if (pose.held.empty() || !pose.tells(edge)) return false;
    row = edge * pose.solve;
    for (const PanelPose::Held& held : pose.held) carrying.push_back({held.bracket, held.direction, true});
    for (const auto& [seat, lift] : pose.seats)
      if (const double factor = edge * lift; std::abs(factor) > kNoPart) seats.emplace_back(seat, factor);
    return true;
  }

  const Facade& facade_;
  std::vector<PanelPose> poses_;
  std::vector<bool> asked_;
};

}  // namespace

std::vector<PanelPose> poses_of(const Facade& facade) { return Stack(facade).poses(); }

namespace {

constexpr const char* kCorners[] = {"bottom left", "bottom right", "top left", "top right"};

void add_corners(const Facade& facade, std::size_t j, const PanelPose& pose, std::vector<JudgedValue>& values,
                 std::vector<std::string>& untold) {
  const Panel& panel = facade.panels[j];
  std::set<int> missing;
  for (int corner = 0; corner < 4; ++corner)
    for (int k = 0; k < 3; ++k) {
      const auto row = pose.movement(panel, panel.corners[corner], panel.axes.col(k));
      if (!pose.tells(row)) {
        missing.insert(k);
        continue;
      }
      JudgedValue value;
      value.panel = j, value.corner = corner, value.direction = k;
      value.low = -panel.limits.back(k), value.high = panel.limits[k];
      value.rows = {{j, row}};
      if (k == 2) value.edges = {{5 * j + 4, 1.0}};
      values.push_back(std::move(value));
    }
  for (const int k : missing)
    untold.push_back("panel " + panel.id + ": its measured hooks do not tell how far its corners move " +
                     kDirections[k]);
}

void add_joint(const Facade& facade, std::size_t index, const std::vector<PanelPose>& poses,
               std::vector<JudgedValue>& values, std::vector<std::string>& untold) {
  const Joint& joint = facade.joints[index];
  const Panel &a = facade.panels[joint.a], &b = facade.panels[joint.b];
  bool told = true;
  for (int end = 0; end < 2; ++end)
    for (const Quantity quantity : {Quantity::gap, Quantity::step}) {
      if (quantity == Quantity::step && !std::isfinite(joint.step_most)) continue;
      const Eigen::Vector3d direction = quantity == Quantity::gap ? joint.across : Eigen::Vector3d(a.axes.col(2));
      const auto of_a = poses[joint.a].movement(a, joint.on_a[end], direction);
      const auto of_b = poses[joint.b].movement(b, joint.on_b[end], direction);
      if (!poses[joint.a].tells(of_a) || !poses[joint.b].tells(of_b)) {
        told = false;
        continue;
      }
      JudgedValue value;
      value.quantity = quantity, value.panel = joint.a, value.joint = static_cast<int>(index), value.end = end;
      value.rows = {{joint.a, -of_a}, {joint.b, of_b}};
      if (quantity == Quantity::gap) {
        value.constant = joint.nominal, value.low = joint.least, value.high = joint.most;
        value.edges = {{5 * joint.a + static_cast<std::size_t>(joint.side_of_a), -1.0},
                       {5 * joint.b + static_cast<std::size_t>(joint.side_of_b), 1.0}};
      } else {
        value.low = -joint.step_most, value.high = joint.step_most;
        value.edges = {{5 * joint.a + 4, -1.0}, {5 * joint.b + 4, 1.0}};
      }
      values.push_back(std::move(value));
    }
  if (!told) untold.push_back("the joint of " + a.id + " and " + b.id + ": measured hooks do not tell all of it");
}

}  // namespace

std::string JudgedValue::words(const Facade& facade) const {
  if (quantity == Quantity::corner)
    return "corner " + std::string(kCorners[corner]) + " of " + facade.panels[panel].id + ", " + kDirections[direction];
  const Joint& j = facade.joints[joint];
  return std::string(quantity == Quantity::gap ? "gap" : "step") + " from " + facade.panels[j.a].id + " to " +
         facade.panels[j.b].id;
}

std::vector<JudgedValue> judged_values(const Facade& facade, const std::vector<PanelPose>& poses,
                                       std::vector<std::string>& untold) {
  std::vector<JudgedValue> values;
  for (std::size_t j = 0; j < facade.panels.size(); ++j) add_corners(facade, j, poses[j], values, untold);
  for (std::size_t i = 0; i < facade.joints.size(); ++i) add_joint(facade, i, poses, values, untold);
  return values;
}

std::map<std::size_t, Eigen::RowVector3d> bracket_gradient(const JudgedValue& value,
                                                           const std::vector<PanelPose>& poses) {
  std::map<std::size_t, Eigen::RowVector3d> gradient;
  for (const auto& [panel, row] : value.rows) {
    const PanelPose& pose = poses[panel];
    const Eigen::RowVectorXd of_held = row * pose.solve;
    for (Eigen::Index i = 0; i < of_held.size(); ++i) {
      const PanelPose::Held& held = pose.held[i];
      gradient.try_emplace(held.bracket, Eigen::RowVector3d::Zero()).first->second +=
          of_held[i] * held.direction.transpose();
    }
  }
  return gradient;
}

Eigen::MatrixXd ValueErrors::covariance() const {
  Eigen::MatrixXd all = covariance_when(-1);
  for (const RareEvent& event : rare) all += event.share * event.shift * event.shift.transpose();
  return all;
}

Eigen::MatrixXd ValueErrors::covariance_when(int event) const {
  Eigen::MatrixXd all = measured + setting + station + made;
  if (event >= 0) {
    const Eigen::MatrixXd& shift = rare[event].shift;
    all += shift * shift.transpose();
  }
  return 0.5 * (all + all.transpose());
}

namespace {

/// Brackets that are still to be set slip; plates and control were knocked before anybody measured, or not.
void add_rare_events(const Facade& facade, const Eigen::MatrixXd& gradient, ValueErrors& errors) {
  const ErrorModel& model = facade.errors;
  std::map<int, Eigen::MatrixXd> heights;  // by storey
  for (std::size_t i = 0; i < errors.brackets.size(); ++i) {
    const Bracket& bracket = facade.brackets[errors.brackets[i]];
    const Eigen::MatrixXd rows = gradient.middleCols<3>(3 * static_cast<Eigen::Index>(i));
    if (model.slip_share * model.slip > 0 && !bracket.stays())
      errors.rare.push_back({model.slip_share, model.slip * rows});
    if (model.knock_share * model.knock > 0) errors.rare.push_back({model.knock_share, model.knock * rows});
    Eigen::MatrixXd& height = heights.try_emplace(bracket.floor, Eigen::MatrixXd::Zero(rows.rows(), 1)).first->second;
    height += model.control_knock * rows.col(2);
  }
  if (model.control_share * model.control_knock > 0)
    for (auto& [storey, shift] : heights) errors.rare.push_back({model.control_share, std::move(shift)});
}

/// What the brackets' errors do to the values, `rows` of d(value)/d(movement): bracket by bracket, because of a high
/// column they are many and their covariances as matrices large.
void add_brackets(const Facade& facade, const Eigen::MatrixXd& rows, ValueErrors& out) {
  const ErrorModel& errors = facade.errors;
  const Eigen::MatrixXd& own = facade.own.size() > 0 ? facade.own : facade.covariance;
  const auto m = rows.rows(), n = static_cast<Eigen::Index>(out.brackets.size());
  const auto at = [&](Eigen::Index i) { return 3 * static_cast<Eigen::Index>(out.brackets[i]); };
  Eigen::MatrixXd with_measured = Eigen::MatrixXd::Zero(m, 3 * n), with_station = with_measured;
  out.with_own.setZero(m, 3 * n), out.setting.setZero(m, m);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Bracket& bracket = facade.brackets[out.brackets[i]];
    const auto row = rows.middleCols<3>(3 * i);
    out.own_alone.emplace_back(own.block<3, 3>(at(i), at(i)));
    if (!bracket.stays()) out.setting += errors.setting * errors.setting * row * row.transpose();
    for (Eigen::Index j = 0; j < n; ++j) {
      const Bracket& other = facade.brackets[out.brackets[j]];
      with_measured.middleCols<3>(3 * j) += row * facade.covariance.block<3, 3>(at(i), at(j));
      out.with_own.middleCols<3>(3 * j) += row * own.block<3, 3>(at(i), at(j));
      if (bracket.stays() || other.stays()) continue;
      if (bracket.floor == other.floor) with_station.middleCols<3>(3 * j) += errors.station * errors.station * row;
      if (facade.stations.size() > 0)
        with_station.middleCols<3>(3 * j) += row * facade.stations.block<3, 3>(at(i), at(j));
    }
  }
  out.measured = with_measured * rows.transpose(), out.own = out.with_own * rows.transpose();
  out.station = with_station * rows.transpose();
}

}  // namespace

ValueErrors errors_of(const std::vector<const JudgedValue*>& values, const Facade& facade,
                      const std::vector<PanelPose>& poses) {
  const auto m = static_cast<Eigen::Index>(values.size());
  std::vector<std::map<std::size_t, Eigen::RowVector3d>> gradients;
  std::map<std::size_t, Eigen::Index> place, edge, seat;  // of a bracket, an edge, a seat among those concerned
  for (const JudgedValue* value : values) {
    gradients.push_back(bracket_gradient(*value, poses));
    for (const auto& [bracket, row] : gradients.back()) place.try_emplace(bracket, 0);
    for (const auto& [at, factor] : value->edges) edge.try_emplace(at, 0);
    for (const auto& [panel, row] : value->rows)
      for (const auto& [at, lift] : poses[panel].seats) seat.try_emplace(at, 0);
  }
  Eigen::Index n = 0, edges = 0;
  ValueErrors out;
  for (auto& [bracket, at] : place) at = n++, out.brackets.push_back(bracket);
  for (auto& [which, at] : edge) at = edges++;
  for (auto& [which, at] : seat) at = edges++;
  const ErrorModel& errors = facade.errors;
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(m, 3 * n);
  for (Eigen::Index v = 0; v < m; ++v)
    for (const auto& [bracket, row] : gradients[v]) rows.block<1, 3>(v, 3 * place.at(bracket)) = row;
  add_brackets(facade, rows, out);
  Eigen::MatrixXd made = Eigen::MatrixXd::Zero(m, edges);
  for (Eigen::Index v = 0; v < m; ++v) {
    const JudgedValue& value = *values[v];
    for (const auto& [which, factor] : value.edges)
      made(v, edge.at(which)) = factor * (which % 5 == 4 ? errors.face : errors.edge);
    for (const auto& [panel, row] : value.rows)
      for (const auto& [at, lift] : poses[panel].seats)
        made(v, seat.at(at)) += row.dot(lift) * facade.panels[at].below->sigma;
  }
  out.made = made * made.transpose();
  add_rare_events(facade, rows, out);
  return out;
}

}  // namespace plumbline::loop

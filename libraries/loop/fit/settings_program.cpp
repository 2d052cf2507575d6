#include "loop/fit/settings_program.hpp"

#include <cmath>

namespace plumbline::loop {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// Weight of a hook that a bracket holds which is set no more: with more such hooks than a panel has freedoms, it
/// cannot follow all.
constexpr double kHoldWeight = 1e3;

/// The axis of the bracket that a hook holds, as 1, 2, 3 with the sign of its direction; 0: none.
int axis_of(const Bracket& bracket, const Eigen::Vector3d& direction) {
  const Eigen::Vector3d along = bracket.axes.transpose() * direction;
  for (int c = 0; c < 3; ++c)
    if (std::abs(std::abs(along[c]) - 1) < 1e-9) return along[c] > 0 ? c + 1 : -(c + 1);
  return 0;
}

}  // namespace

SettingsProgram::SettingsProgram(const Facade& facade, const std::vector<PanelPose>& poses,
                                 const std::vector<JudgedValue>& judged, const FitWeights& weights)
    : facade_(facade), poses_(poses) {
  for (std::size_t j = 0; j < facade.panels.size(); ++j) {
    known_.push_back(Eigen::Matrix<double, 6, 1>::Zero());
    const PanelPose& pose = poses[j];
    twist_at_.push_back(-1);
    if (pose.held.empty()) continue;
    if (!facade.panels[j].installed) {
      twist_at_.back() = unknowns_, unknowns_ += 6;
      continue;
    }
    Eigen::VectorXd moved(pose.solve.cols());
    for (Eigen::Index i = 0; i < moved.size(); ++i) {
      const PanelPose::Held& held = pose.held[i];
      moved[i] = 1e3 * held.direction.dot(facade.brackets[held.bracket].deviation);
    }
    known_.back() = pose.solve * moved;
  }
  choose_settings();
  for (std::size_t j = 0; j < facade.panels.size(); ++j)
    for (std::size_t i = 0; twist_at_[j] >= 0 && i < poses[j].held.size(); ++i)
      add_hook(j, static_cast<Eigen::Index>(i));
  linear_.assign(static_cast<std::size_t>(unknowns_), 0.0);
  for (const JudgedValue& value : judged) value_rows_.push_back(row_of(value));
  add_squares(judged, weights);
}

/// Settings are unknowns only of brackets that a hook holds across their axes, as at a corner of two facades. A
/// direction that nothing holds stays unset.
void SettingsProgram::choose_settings() {
  settings_.resize(facade_.brackets.size());
  for (const Bracket& bracket : facade_.brackets) is_set_.push_back(bracket.measured() && !bracket.fixed);
  std::vector<bool> across(facade_.brackets.size(), false);
  for (std::size_t j = 0; j < facade_.panels.size(); ++j)
    for (std::size_t i = 0; twist_at_[j] >= 0 && i < poses_[j].held.size(); ++i) {
      const PanelPose::Held& held = poses_[j].held[i];
      if (axis_of(facade_.brackets[held.bracket], held.direction) == 0) across[held.bracket] = true;
    }
  for (std::size_t b = 0; b < across.size(); ++b)
    for (Term& term : settings_[b])
      if (is_set_[b] && across[b]) term = {{{unknowns_++, 1.0}}, 0, true};
}

/// The hook's end of the panel moves by what its anchor is off and is set by.
void SettingsProgram::add_hook(std::size_t panel, Eigen::Index held) {
  const PanelPose::Held& hook = poses_[panel].held[held];
  const Bracket& bracket = facade_.brackets[hook.bracket];
  const double deviation = 1e3 * hook.direction.dot(bracket.deviation);
  Row movement;
  for (Eigen::Index c = 0; c < 6; ++c) movement.emplace_back(twist_at_[panel] + c, poses_[panel].hooks(held, c));
  const int axis = axis_of(bracket, hook.direction);
  const double sign = axis < 0 ? -1 : 1;
  if (is_set_[hook.bracket] && axis != 0) {
    Term& term = settings_[hook.bracket][std::abs(axis) - 1];
    if (!term.is_told) {
      term = {movement, -sign * deviation, true};
      for (auto& [at, factor] : term.row) factor *= sign;
      return;
    }
  }
  const auto row = static_cast<int>(right_sides_.size());
  double right = deviation;
  for (const auto& [at, factor] : movement) equations_.emplace_back(row, static_cast<int>(at), factor);
  if (is_set_[hook.bracket]) {
    const Eigen::Vector3d along = bracket.axes.transpose() * hook.direction;
    for (int c = 0; c < 3; ++c) {
      const Term& term = settings_[hook.bracket][c];
      if (std::abs(along[c]) <= 1e-9) continue;
      for (const auto& [at, factor] : term.row) equations_.emplace_back(row, static_cast<int>(at), -along[c] * factor);
      right += along[c] * term.constant;
    }
  } else {
    equations_.emplace_back(row, static_cast<int>(unknowns_), 1.0);
    squares_.emplace_back(static_cast<int>(unknowns_), static_cast<int>(unknowns_), 2 * kHoldWeight);
    ++unknowns_;
  }
  right_sides_.push_back(right);
}

std::pair<SettingsProgram::Row, double> SettingsProgram::row_of(const JudgedValue& value) const {
  Row row;
  double constant = 1e3 * value.constant;
  for (const auto& [panel, movement] : value.rows) {
    if (twist_at_[panel] < 0) {
      constant += movement.dot(known_[panel]);
      continue;
    }
    for (Eigen::Index c = 0; c < 6; ++c)
      if (std::abs(movement[c]) > 1e-12) row.emplace_back(twist_at_[panel] + c, movement[c]);
  }
  return {row, constant};
}

/// weight * (row x + constant)².
void SettingsProgram::add_square(const Row& row, double constant, double weight) {
  constant_ += weight * constant * constant;
  for (const auto& [i, a] : row) {
    linear_[i] += 2 * weight * constant * a;
    for (const auto& [j, b] : row) squares_.emplace_back(static_cast<int>(i), static_cast<int>(j), 2 * weight * a * b);
  }
}

void SettingsProgram::add_squares(const std::vector<JudgedValue>& judged, const FitWeights& weights) {
  for (std::size_t v = 0; v < judged.size(); ++v) {
    const auto& [row, constant] = value_rows_[v];
    if (judged[v].quantity == Quantity::gap) add_square(row, constant - 1e3 * judged[v].constant, weights.gap / 2);
    if (judged[v].quantity == Quantity::step) add_square(row, constant, weights.step / 2);
  }
  for (std::size_t j = 0; j < facade_.panels.size(); ++j) {
    if (twist_at_[j] < 0) continue;
    const Panel& panel = facade_.panels[j];
    for (const Eigen::Vector3d& corner : panel.corners)  // also of what the hooks do not tell: that stays at zero
      for (int k = 0; k < 3; ++k) {
        const auto movement = poses_[j].movement(panel, corner, panel.axes.col(k));
        Row row;
        for (Eigen::Index c = 0; c < 6; ++c)
          if (std::abs(movement[c]) > 1e-12) row.emplace_back(twist_at_[j] + c, movement[c]);
        add_square(row, 0, weights.pose / 4);
      }
  }
  for (const auto& terms : settings_)
    for (const Term& term : terms) add_square(term.row, term.constant, weights.setting);
}

ConvexProgram SettingsProgram::with(const std::vector<Limit>& limits) const {
  ConvexProgram program;
  const auto equations = static_cast<Eigen::Index>(right_sides_.size());
  const auto count = static_cast<Eigen::Index>(limits.size());
  const Eigen::Index n = unknowns_ + count, m = equations + count;
  program.quadratic.resize(n, n), program.quadratic.setFromTriplets(squares_.begin(), squares_.end());
  program.linear = Eigen::VectorXd::Zero(n);
  program.linear.head(static_cast<Eigen::Index>(linear_.size())) =
      Eigen::Map<const Eigen::VectorXd>(linear_.data(), static_cast<Eigen::Index>(linear_.size()));
  program.x_low = Eigen::VectorXd::Constant(n, -kInfinity), program.x_high = Eigen::VectorXd::Constant(n, kInfinity);
  program.x_low.tail(count).setZero();
  program.low.resize(m), program.high.resize(m);
  program.low.head(equations) = Eigen::Map<const Eigen::VectorXd>(right_sides_.data(), equations);
  program.high.head(equations) = program.low.head(equations);
  std::vector<Eigen::Triplet<double>> rows = equations_;
  for (Eigen::Index i = 0; i < count; ++i) {
    const Limit& limit = limits[i];
    const auto at = static_cast<int>(equations + i), excess = static_cast<int>(unknowns_ + i);
    double constant = 0;
    if (limit.value >= 0) {
      constant = value_rows_[limit.value].second;
      for (const auto& [j, a] : value_rows_[limit.value].first) rows.emplace_back(at, static_cast<int>(j), a);
    } else {
      const Term& term = settings_[limit.bracket][limit.direction];
      constant = term.constant;
      for (const auto& [j, a] : term.row) rows.emplace_back(at, static_cast<int>(j), a);
    }
    rows.emplace_back(at, excess, std::isfinite(limit.high) ? -1.0 : 1.0);
    program.linear[excess] = limit.value >= 0 ? kTolerancePrice : kRangePrice;
    program.low[at] = limit.low - constant, program.high[at] = limit.high - constant;
  }
  program.constant = constant_;
  program.rows.resize(m, n), program.rows.setFromTriplets(rows.begin(), rows.end());
  return program;
}

double SettingsProgram::value_of(const Term& term, const Eigen::VectorXd& x) const {
  double sum = term.constant;
  for (const auto& [i, a] : term.row) sum += a * x[i];
  return sum;
}

double SettingsProgram::at(const Limit& limit, const Eigen::VectorXd& x) const {
  if (limit.value < 0) return value_of(settings_[limit.bracket][limit.direction], x);
  const auto& [row, constant] = value_rows_[limit.value];
  return value_of({row, constant, true}, x);
}

Eigen::Vector3d SettingsProgram::setting(std::size_t bracket, const Eigen::VectorXd& x) const {
  Eigen::Vector3d setting = Eigen::Vector3d::Zero();
  for (std::size_t c = 0; is_set_[bracket] && c < 3; ++c)
    setting[static_cast<Eigen::Index>(c)] = 1e-3 * value_of(settings_[bracket][c], x);
  return setting;
}

}  // namespace plumbline::loop

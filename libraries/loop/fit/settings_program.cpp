#include "loop/fit/settings_program.hpp"

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseQR>
#include <algorithm>
#include <cmath>

namespace plumbline::loop {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// Weight of a hook that a bracket holds which is set no more: with more such hooks than a panel has freedoms, it
/// cannot follow all.
constexpr double kHoldWeight = 1e3;
/// Parts of a unit vector, and of a row, that count for nothing.
constexpr double kNothing = 1e-9;

}  // namespace

void SettingsProgram::Term::add(double factor, const Term& other) {
  constant += factor * other.constant;
  for (const auto& [at, a] : other.row) {
    const auto found = std::find_if(row.begin(), row.end(), [at = at](const auto& entry) { return entry.first == at; });
    if (found != row.end())
      found->second += factor * a;
    else
      row.emplace_back(at, factor * a);
  }
}

double SettingsProgram::Term::value(const Eigen::VectorXd& x) const {
  double sum = constant;
  for (const auto& [at, a] : row) sum += a * x[at];
  return sum;
}

SettingsProgram::SettingsProgram(const Facade& facade, const std::vector<PanelPose>& poses,
                                 const std::vector<JudgedValue>& judged, const FitWeights& weights)
    : facade_(facade), poses_(poses) {
  choose_settings();
  hooks_.resize(facade.panels.size());
  edges_.resize(facade.panels.size());
  for (std::size_t j = 0; j < facade.panels.size(); ++j) add_hooks(j);
  for (std::size_t j = 0; j < facade.panels.size(); ++j) add_edge(j);
  keep_independent_equations();
  linear_.assign(static_cast<std::size_t>(unknowns_), 0.0);
  for (const JudgedValue& value : judged) {
    values_.emplace_back().constant = 1e3 * value.constant;
    for (const auto& [panel, row] : value.rows) values_.back().add(1, term_of(panel, row));
  }
  add_squares(judged, weights);
}

/// A direction that no hook of a panel holds which is still to be hung stays unset.
void SettingsProgram::choose_settings() {
  settings_.resize(facade_.brackets.size());
  for (const Bracket& bracket : facade_.brackets) is_set_.push_back(bracket.measured() && !bracket.stays());
  std::vector<std::array<bool, 3>> holds(facade_.brackets.size(), {false, false, false});
  for (std::size_t j = 0; j < facade_.panels.size(); ++j)
    for (const PanelPose::Held& held : poses_[j].held) {
      if (facade_.panels[j].installed) continue;
      const Eigen::Vector3d along = facade_.brackets[held.bracket].axes.transpose() * held.direction;
      for (int c = 0; c < 3; ++c) holds[held.bracket][c] = holds[held.bracket][c] || std::abs(along[c]) > kNothing;
    }
  for (std::size_t b = 0; b < holds.size(); ++b)
    for (int c = 0; c < 3; ++c)
      if (is_set_[b] && holds[b][c]) settings_[b][c].row.emplace_back(unknowns_++, 1.0);
}

/// The hook's end of the panel moves by what its anchor is off and is set by. What hangs already stays as it is.
void SettingsProgram::add_hooks(std::size_t panel) {
  const PanelPose& pose = poses_[panel];
  for (Eigen::Index own = 0; own < pose.own(); ++own) {
    const PanelPose::Held& held = pose.held[static_cast<std::size_t>(own)];
    const Bracket& bracket = facade_.brackets[held.bracket];
    const auto hook = static_cast<Eigen::Index>(hooks_[panel].size());
    Term& moved = hooks_[panel].emplace_back();
    moved.constant = 1e3 * held.direction.dot(bracket.deviation);
    if (facade_.panels[panel].installed && !held.is_below) continue;
    const Eigen::Vector3d along = bracket.axes.transpose() * held.direction;
    for (int c = 0; is_set_[held.bracket] && c < 3; ++c)
      if (std::abs(along[c]) > kNothing) moved.add(along[c], settings_[held.bracket][c]);
    if (held.is_below || is_set_[held.bracket] || pose.strain.cols() == 0 || pose.strain.row(hook).norm() <= kNothing)
      continue;
    moved.row.emplace_back(unknowns_, 1.0);
    squares_.emplace_back(static_cast<int>(unknowns_), static_cast<int>(unknowns_), 2 * kHoldWeight);
    ++unknowns_;
  }
  for (Eigen::Index g = 0; !facade_.panels[panel].installed && g < pose.strain.cols(); ++g) {
    Term strain;
    for (std::size_t i = 0; i < hooks_[panel].size(); ++i)
      strain.add(pose.strain(static_cast<Eigen::Index>(i), g), hooks_[panel][i]);
    add_equation(strain);
  }
}

/// The panel below is asked first, however the panels are ordered.
void SettingsProgram::add_edge(std::size_t panel) {
  const auto& stand = poses_[panel].stand;
  if (!stand || edges_[panel]) return;
  add_edge(stand->carrier);
  Term below = term_of(stand->carrier, stand->edge);
  if (below.row.empty()) {
    edges_[panel] = std::move(below);
    return;
  }
  Term edge;
  edge.row.emplace_back(unknowns_++, 1.0);
  below.add(-1, edge);
  add_equation(below);
  edges_[panel] = std::move(edge);
}

/// term = 0.
void SettingsProgram::add_equation(const Term& term) {
  const auto row = static_cast<int>(right_sides_.size());
  for (const auto& [at, a] : term.row)
    if (std::abs(a) > kNothing) equations_.emplace_back(row, static_cast<int>(at), a);
  right_sides_.push_back(-term.constant);
}

/// Two panels on the same four brackets have one equation: no solver stands one that is there twice.
void SettingsProgram::keep_independent_equations() {
  const auto count = static_cast<int>(right_sides_.size());
  if (count < 2) return;
  std::vector<Eigen::Triplet<double>> entries;
  for (const auto& entry : equations_) entries.emplace_back(entry.col(), entry.row(), entry.value());
  Eigen::SparseMatrix<double> columns(unknowns_, count);
  columns.setFromTriplets(entries.begin(), entries.end());
  // The rule are equations that do not depend on each other, and a Cholesky factor tells that in a fiftieth of the
  // time.
  const Eigen::SparseMatrix<double> products = columns.transpose() * columns;
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor(products);
  if (factor.info() == Eigen::Success && factor.vectorD().minCoeff() > kNothing * factor.vectorD().maxCoeff()) return;
  Eigen::SparseQR<Eigen::SparseMatrix<double>, Eigen::COLAMDOrdering<int>> qr;
  qr.setPivotThreshold(kNothing);
  qr.compute(columns);
  if (qr.info() != Eigen::Success || qr.rank() == count) return;
  std::vector<int> place(right_sides_.size(), -1);
  for (Eigen::Index i = 0; i < qr.rank(); ++i) place[qr.colsPermutation().indices()[i]] = 0;
  std::vector<double> right_sides;
  for (std::size_t i = 0; i < place.size(); ++i) {
    if (place[i] < 0) continue;
    place[i] = static_cast<int>(right_sides.size());
    right_sides.push_back(right_sides_[i]);
  }
  entries.clear();
  for (const auto& entry : equations_)
    if (place[entry.row()] >= 0) entries.emplace_back(place[entry.row()], entry.col(), entry.value());
  equations_ = std::move(entries), right_sides_ = std::move(right_sides);
}

/// What moves with the twist of a panel: row * twist.
SettingsProgram::Term SettingsProgram::term_of(std::size_t panel, const Eigen::Matrix<double, 1, 6>& row) const {
  const Eigen::RowVectorXd of_hooks = row * poses_[panel].solve;
  Term term;
  for (std::size_t i = 0; i < hooks_[panel].size(); ++i)
    if (const double a = of_hooks[static_cast<Eigen::Index>(i)]; std::abs(a) > 1e-3 * kNothing)
      term.add(a, hooks_[panel][i]);
  if (edges_[panel]) term.add(row * poses_[panel].stand->lift, *edges_[panel]);
  return term;
}

const SettingsProgram::Term& SettingsProgram::term_of(const Limit& limit) const {
  return limit.value >= 0 ? values_[limit.value] : settings_[limit.bracket][limit.direction];
}

/// weight * term².
void SettingsProgram::add_square(const Term& term, double weight) {
  constant_ += weight * term.constant * term.constant;
  for (const auto& [i, a] : term.row) {
    linear_[i] += 2 * weight * term.constant * a;
    for (const auto& [j, b] : term.row)
      squares_.emplace_back(static_cast<int>(i), static_cast<int>(j), 2 * weight * a * b);
  }
}

void SettingsProgram::add_squares(const std::vector<JudgedValue>& judged, const FitWeights& weights) {
  for (std::size_t v = 0; v < judged.size(); ++v) {
    Term change = values_[v];
    if (judged[v].quantity == Quantity::gap) change.constant -= 1e3 * judged[v].constant;
    if (judged[v].quantity != Quantity::corner)
      add_square(change, 0.5 * (judged[v].quantity == Quantity::gap ? weights.gap : weights.step));
  }
  for (std::size_t j = 0; j < facade_.panels.size(); ++j) {
    const Panel& panel = facade_.panels[j];
    if (panel.installed || poses_[j].held.empty()) continue;
    for (const Eigen::Vector3d& corner : panel.corners)
      for (int k = 0; k < 3; ++k)
        add_square(term_of(j, poses_[j].movement(panel, corner, panel.axes.col(k))), weights.pose / 4);
  }
  for (const auto& settings : settings_)
    for (const Term& setting : settings) add_square(setting, weights.setting);
}

ConvexProgram SettingsProgram::with(const std::vector<Limit>& limits) const {
  ConvexProgram program;
  const auto equations = static_cast<Eigen::Index>(right_sides_.size());
  const auto count = static_cast<Eigen::Index>(limits.size());
  const Eigen::Index n = unknowns_ + count, m = equations + count;
  program.quadratic.resize(n, n), program.quadratic.setFromTriplets(squares_.begin(), squares_.end());
  program.linear = Eigen::VectorXd::Zero(n);
  program.linear.head(unknowns_) = Eigen::Map<const Eigen::VectorXd>(linear_.data(), unknowns_);
  program.x_low = Eigen::VectorXd::Constant(n, -kInfinity), program.x_high = Eigen::VectorXd::Constant(n, kInfinity);
  program.x_low.tail(count).setZero();
  program.low.resize(m), program.high.resize(m);
  program.low.head(equations) = Eigen::Map<const Eigen::VectorXd>(right_sides_.data(), equations);
  program.high.head(equations) = program.low.head(equations);
  std::vector<Eigen::Triplet<double>> rows = equations_;
  for (Eigen::Index i = 0; i < count; ++i) {
    const Limit& limit = limits[i];
    const auto at = static_cast<int>(equations + i), excess = static_cast<int>(unknowns_ + i);
    const Term& term = term_of(limit);
    for (const auto& [j, a] : term.row) rows.emplace_back(at, static_cast<int>(j), a);
    rows.emplace_back(at, excess, std::isfinite(limit.high) ? -1.0 : 1.0);
    program.linear[excess] = price_of(limit);
    program.low[at] = limit.low - term.constant, program.high[at] = limit.high - term.constant;
  }
  program.constant = constant_;
  program.rows.resize(m, n), program.rows.setFromTriplets(rows.begin(), rows.end());
  return program;
}

double SettingsProgram::at(const Limit& limit, const Eigen::VectorXd& x) const { return term_of(limit).value(x); }

Eigen::Vector3d SettingsProgram::setting(std::size_t bracket, const Eigen::VectorXd& x) const {
  Eigen::Vector3d setting = Eigen::Vector3d::Zero();
  for (std::size_t c = 0; is_set_[bracket] && c < 3; ++c)
    setting[static_cast<Eigen::Index>(c)] = 1e-3 * settings_[bracket][c].value(x);
  return setting;
}

}  // namespace plumbline::loop

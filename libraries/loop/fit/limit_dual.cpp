#include "loop/fit/limit_dual.hpp"

#include <algorithm>
#include <cmath>

namespace plumbline::loop {
namespace {

/// A solution that is off by more of its right side comes from equations that depend on each other.
constexpr double kRegular = 1e-9;

bool is_upper(const Limit& limit) { return std::isfinite(limit.high); }
double sign_of(const Limit& limit) { return is_upper(limit) ? 1.0 : -1.0; }
std::tuple<int, int, int> name_of(const Limit& limit) { return {limit.bracket, limit.direction, limit.value}; }

/// By how much `at` breaks the limit; negative: by how much it keeps it.
double excess_of(const Limit& limit, double at) { return is_upper(limit) ? at - limit.high : limit.low - at; }

/// [Q E'; E 0] of minimise 1/2 x'Qx + c'x subject to E x = f.
Eigen::SparseMatrix<double> saddle_of(const ConvexProgram& program) {
  const auto n = program.linear.size(), m = program.rows.rows();
  std::vector<Eigen::Triplet<double>> entries;
  for (int k = 0; k < program.quadratic.outerSize(); ++k)
    for (Eigen::SparseMatrix<double>::InnerIterator it(program.quadratic, k); it; ++it)
      entries.emplace_back(it.row(), it.col(), it.value());
  for (int k = 0; k < program.rows.outerSize(); ++k)
    for (Eigen::SparseMatrix<double, Eigen::RowMajor>::InnerIterator it(program.rows, k); it; ++it) {
      entries.emplace_back(n + it.row(), it.col(), it.value());
      entries.emplace_back(it.col(), n + it.row(), it.value());
    }
  Eigen::SparseMatrix<double> saddle(n + m, n + m);
  saddle.setFromTriplets(entries.begin(), entries.end());
  return saddle;
}

}  // namespace

LimitDual::LimitDual(const SettingsProgram& program) : program_(program), base_(program.with({})) {
  const Eigen::SparseMatrix<double> saddle = saddle_of(base_);
  if (saddle.rows() == 0) return;
  factor_.isSymmetric(true);
  factor_.compute(saddle);
  if (factor_.info() != Eigen::Success) return;
  Eigen::VectorXd right(saddle.rows());
  right << -base_.linear, base_.low;
  free_ = factor_.solve(right);
  const double off = (saddle * free_ - right).lpNorm<Eigen::Infinity>();
  is_regular_ = off <= kRegular * (1 + right.lpNorm<Eigen::Infinity>());
  responses_.resize(saddle.rows(), 0);
}

Eigen::Index LimitDual::column_of(const Limit& limit) const { return columns_.at(name_of(limit)); }

/// Responses to limits that were not asked for before.
void LimitDual::learn(const std::vector<Limit>& limits) {
  std::vector<const Limit*> unknown;
  for (const Limit& limit : limits)
    if (columns_.emplace(name_of(limit), responses_.cols() + static_cast<Eigen::Index>(unknown.size())).second)
      unknown.push_back(&limit);
  const auto count = static_cast<Eigen::Index>(unknown.size());
  if (count == 0) return;
  Eigen::MatrixXd forces = Eigen::MatrixXd::Zero(responses_.rows(), count);
  for (Eigen::Index k = 0; k < count; ++k)
    for (const auto& [at, a] : program_.term_of(*unknown[k]).row) forces(at, k) += a;
  responses_.conservativeResize(Eigen::NoChange, responses_.cols() + count);
  responses_.rightCols(count) = factor_.solve(forces);
}

/// minimise 1/2 y'Sy - b'y subject to 0 <= y <= price, with S = A K^-1 A' of the limits' rows A x <= .. and b by how
/// much the optimum without limits breaks them. Ipopt gets t = sqrt(S_ii) y: a millimetre takes forces that differ by
/// orders of magnitude from limit to limit.
Eigen::VectorXd LimitDual::multipliers(const std::vector<Limit>& limits) const {
  const auto count = static_cast<Eigen::Index>(limits.size());
  Eigen::MatrixXd moved(count, count);
  for (Eigen::Index i = 0; i < count; ++i)
    for (Eigen::Index j = 0; j <= i; ++j) {
      const Eigen::Index column = column_of(limits[j]);
      double sum = 0;
      for (const auto& [at, a] : program_.term_of(limits[i]).row) sum += a * responses_(at, column);
      moved(i, j) = moved(j, i) = sign_of(limits[i]) * sign_of(limits[j]) * sum;
    }
  ConvexProgram dual;
  Eigen::VectorXd scale(count);
  dual.linear.resize(count), dual.x_low = Eigen::VectorXd::Zero(count), dual.x_high.resize(count);
  dual.rows.resize(0, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const double price = price_of(limits[i]);
    scale[i] = 1 / std::max(std::sqrt(std::max(0.0, moved(i, i))), 1 / price);  // what moves nothing: y / price
    dual.linear[i] = -scale[i] * excess_of(limits[i], program_.at(limits[i], free_));
    dual.x_high[i] = price / scale[i];
  }
  const Eigen::MatrixXd quadratic = scale.asDiagonal() * moved * scale.asDiagonal();
  dual.quadratic = quadratic.sparseView();
  return scale.cwiseProduct(minimise(dual).x);
}

ConvexOptimum LimitDual::optimum(const std::vector<Limit>& limits) {
  learn(limits);
  const auto count = static_cast<Eigen::Index>(limits.size()), n = base_.linear.size(), m = base_.rows.rows();
  const Eigen::VectorXd multiplier = count > 0 ? multipliers(limits) : Eigen::VectorXd();
  Eigen::VectorXd both = free_;
  for (Eigen::Index i = 0; i < count; ++i)
    both -= sign_of(limits[i]) * multiplier[i] * responses_.col(column_of(limits[i]));
  ConvexOptimum optimum;
  optimum.x.resize(n + count), optimum.y.resize(m + count), optimum.z = Eigen::VectorXd::Zero(n + count);
  optimum.x.head(n) = both.head(n), optimum.y.head(m) = both.tail(m);
  optimum.value = both.head(n).dot(0.5 * (base_.quadratic * both.head(n)) + base_.linear) + base_.constant;
  for (Eigen::Index i = 0; i < count; ++i) {
    const double price = price_of(limits[i]),
                 excess = std::max(0.0, excess_of(limits[i], program_.at(limits[i], both)));
    optimum.x[n + i] = excess, optimum.y[m + i] = sign_of(limits[i]) * multiplier[i];
    optimum.z[n + i] = multiplier[i] - price;
    optimum.value += price * excess;
  }
  return optimum;
}

}  // namespace plumbline::loop

#include "least_squares/problem/solver.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "least_squares/problem/descent.hpp"

namespace plumbline::least_squares {

namespace {

struct Step {
  Eigen::VectorXd step;  // unscaled
  double length = 0;     // |J dx|
  double predicted = 0;  // by how much it should lower the sum of squares
};

std::optional<Step> compute_step(Solution& s, double damping) {
  const auto own = std::make_shared<SparseFactor>();
  s.factor.reset();
  if (!own->factorise(s.normal, damping, s.datum.pinned())) return std::nullopt;
  const SparseFactor& factor = *own;
  if (damping == 0) s.factor = own;
  Eigen::VectorXd right_side = -s.normal.gradient().cwiseQuotient(s.normal.scale());
  for (int p : s.datum.pinned()) right_side[p] = 0;
  const Eigen::VectorXd scaled_step = factor.solve(right_side);
  const double square = std::max(0.0, scaled_step.dot(right_side));
  Eigen::VectorXd step = scaled_step.cwiseQuotient(s.normal.scale());
  if (s.datum.defect() > 0) {
    if (damping == 0) s.datum.update(s.normal, factor);
    step += s.datum.shift_for(s.change + step);
  }
  return Step{std::move(step), std::sqrt(square), square + damping * scaled_step.squaredNorm()};
}

std::vector<std::vector<double>> values_of(const Problem& problem) {
  std::vector<std::vector<double>> values;
  for (const auto& block : problem.parameters) values.push_back(block.value);
  return values;
}

void restore(Problem& problem, const std::vector<std::vector<double>>& values) {
  for (size_t b = 0; b < values.size(); ++b) problem.parameters[b].value = values[b];
}

bool same_unknowns(const UnknownIndex& a, const UnknownIndex& b) {
  if (a.count() != b.count()) return false;
  for (int u = 0; u < a.count(); ++u)
    if (a.block_of(u) != b.block_of(u) || a.component_of(u) != b.component_of(u)) return false;
  return true;
}

Solution start(Problem& problem, const SolverOptions& options) {
  UnknownIndex unknowns(problem);
  if (unknowns.count() == 0) throw std::runtime_error("there is nothing to determine: every parameter is held");
  Linearisation lin = prepare_linearisation(problem, unknowns);
  if (!linearise(problem, unknowns, true, lin))
    throw std::runtime_error("an observation cannot be evaluated at the initial values (coinciding points?)");
  const Solution* before =
      options.before && same_unknowns(options.before->unknowns, unknowns) ? options.before : nullptr;
  NormalEquations normal(lin, unknowns, before ? &before->normal : nullptr);
  normal.assemble(lin);
  const Eigen::MatrixXd null_space = find_null_space(normal, options.rank_tolerance);
  InnerConstraints datum(normal, null_space, options.datum_unknowns);
  if (before && before->datum.defect() == datum.defect()) datum = before->datum;
  Solution solution{
      std::move(unknowns), std::move(lin), std::move(normal), std::move(datum), {}, {}, false, 0, nullptr};
  solution.change = before ? before->change : Eigen::VectorXd::Zero(solution.unknowns.count());
  solution.sums_of_squares.push_back(solution.linearisation.sum_of_squares);
  return solution;
}

/// What the last digit of the parameters' values does to the whitened observations: coordinates of millions of metres
/// beside an azimuth that is held to a thousandth of a second are not better known than this, and no step is.
double rounding(const Problem& problem, const Solution& s) {
  constexpr double kLastDigit = 2 * std::numeric_limits<double>::epsilon();
  const Linearisation& lin = s.linearisation;
  double sum = 0;
  for (const Linearisation::Block& block : lin.blocks) {
    const auto jacobian = lin.jacobian_of(block);
    for (int r = 0; r < block.rows; ++r)
      for (int k = 0; k < block.column_count; ++k) {
        const int unknown = lin.columns[block.column_begin + k];
        const ParameterBlock& of = problem.parameters[s.unknowns.block_of(unknown)];
        if (of.plus) continue;
        const double digit = kLastDigit * of.value[s.unknowns.component_of(unknown)];
        sum += std::pow(jacobian(r, k) * digit, 2);
      }
  }
  return std::sqrt(sum);
}

/// Undamped steps, damped only where one would raise the sum of squares.
class NetworkDescent : public DampedSystem {
 public:
  NetworkDescent(Problem& problem, Solution& solution, const SolverOptions& options)
      : problem_(problem), s_(solution), options_(options) {}

  bool build(Where where, double) override {
    if (where == Where::place && is_built_) return true;
    s_.factor.reset();
    is_built_ = linearise(problem_, s_.unknowns, true, s_.linearisation);
    if (is_built_) s_.normal.assemble(s_.linearisation);
    return is_built_;
  }
  double cost() const override { return s_.sum_of_squares(); }
  std::optional<double> solve(double damping) override {
    std::optional<Step> step = compute_step(s_, damping);
    if (!step && damping == 0 && s_.sums_of_squares.size() > 1)
      throw RankDefect("the system became singular during the iterations", Eigen::MatrixXd(s_.unknowns.count(), 0));
    if (!step) return std::nullopt;
    step_ = std::move(*step);
    is_quadratic_ = step_.length < 1e-2 * std::exchange(s_.last_step, step_.length);
    return step_.predicted;
  }
  bool is_negligible(double damping) const override {
    // Measured against the residuals too, so that a sum of squares near zero is still found to all its digits.
    const double negligible = options_.negligible_step * std::min(1.0, std::sqrt(s_.sum_of_squares()));
    return damping == 0 && ((is_quadratic_ && step_.length < negligible) || step_.length < rounding(problem_, s_));
  }
  void try_step() override {
    place_ = values_of(problem_);
    apply_step(problem_, s_.unknowns, step_.step);
  }
  void accept() override {
    s_.change += step_.step;
    s_.sums_of_squares.push_back(s_.sum_of_squares());
  }
  void reject() override {
    restore(problem_, place_);
    is_built_ = false;
  }
  Judgement judge(double gain, double damping) const override {
    // Near the minimum the sum changes by less than its own rounding (each residual is known to about 1e-16 of the
    // observation, not of the residual): such a rise neither confirms nor refutes the step, and ends the search.
    const bool taken = gain >= 0, within_rounding = !taken && step_.length < 1e-3 &&
                                                    -gain < 1e-9 * std::max(1.0, s_.sums_of_squares.back());
    return {taken, damping == 0 && (step_.length < options_.step_tolerance || within_rounding)};
  }

 private:
  Problem& problem_;
  Solution& s_;
  const SolverOptions& options_;
  std::vector<std::vector<double>> place_;
  Step step_;
  bool is_built_ = true, is_quadratic_ = false;
};

}  // namespace

Solution solve(Problem& problem, const SolverOptions& options) {
  Solution s = start(problem, options);
  NetworkDescent system(problem, s, options);
  DescentOptions how;  // damping in units of the scaled normal matrix, whose diagonal is 1
  how.max_iterations = options.max_iterations, how.counts_refused = false;
  how.first_damping = how.rest_damping = 0;
  how.least_damping = 1e-3, how.smallest_damping = 1e-4, how.largest_damping = 1e9;
  s.converged = descend(system, how).converged;
  return s;
}

Eigen::VectorXd gauss_newton_step(Solution& solution) {
  const std::optional<Step> step = compute_step(solution, 0);
  if (!step) throw RankDefect("the normal matrix is singular", Eigen::MatrixXd(solution.unknowns.count(), 0));
  return step->step;
}

void move(Problem& problem, Solution& solution, const Eigen::VectorXd& step) {
  apply_step(problem, solution.unknowns, step);
  solution.change += step;
  solution.factor.reset();
  if (!linearise(problem, solution.unknowns, true, solution.linearisation))
    throw std::runtime_error("an observation cannot be evaluated where a step leads");
  solution.normal.assemble(solution.linearisation);
}

}  // namespace plumbline::least_squares

#include "least_squares/problem/solver.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "plumbline/stop.hpp"

namespace plumbline::least_squares {

namespace {

constexpr double kFirstDamping = 1e-3;  // in units of the scaled normal matrix, whose diagonal is 1
constexpr double kLargestDamping = 1e9;

struct Step {
  Eigen::VectorXd step;  // unscaled
  double length = 0;     // |J dx|
};

std::optional<Step> compute_step(Solution& s, double damping) {
  SparseFactor factor;
  if (!factor.factorise(s.normal, damping, s.datum.pinned())) return std::nullopt;
  Eigen::VectorXd right_side = -s.normal.gradient().cwiseQuotient(s.normal.scale());
  for (int p : s.datum.pinned()) right_side[p] = 0;
  const Eigen::VectorXd scaled_step = factor.solve(right_side);
  const double length = std::sqrt(std::max(0.0, scaled_step.dot(right_side)));
  Eigen::VectorXd step = scaled_step.cwiseQuotient(s.normal.scale());
  if (s.datum.defect() > 0) {
    if (damping == 0) s.datum.update(s.normal, factor);
    step += s.datum.shift_for(s.change + step);
  }
  return Step{std::move(step), length};
}

std::vector<std::vector<double>> values_of(const Problem& problem) {
  std::vector<std::vector<double>> values;
  for (const auto& block : problem.parameters) values.push_back(block.value);
  return values;
}

void restore(Problem& problem, const std::vector<std::vector<double>>& values) {
  for (size_t b = 0; b < values.size(); ++b) problem.parameters[b].value = values[b];
}

/// Takes the step if the sum of squares does not rise; else leaves everything as it was.
bool try_step(Problem& problem, Solution& s, const Step& step, double& rise) {
  const auto before = values_of(problem);
  const double sum_before = s.linearisation.sum_of_squares;
  const Eigen::VectorXd residuals_before = s.linearisation.residuals;
  apply_step(problem, s.unknowns, step.step);
  const bool defined = linearise(problem, s.unknowns, false, s.linearisation);
  rise = defined ? s.linearisation.sum_of_squares - sum_before : std::numeric_limits<double>::infinity();
  if (rise <= 0) {
    s.change += step.step;
    s.sums_of_squares.push_back(s.linearisation.sum_of_squares);
    return true;
  }
  restore(problem, before);
  s.linearisation.residuals = residuals_before;
  s.linearisation.sum_of_squares = sum_before;
  return false;
}

Solution start(Problem& problem, const SolverOptions& options) {
  UnknownIndex unknowns(problem);
  if (unknowns.count() == 0) throw std::runtime_error("there is nothing to determine: every parameter is held");
  Linearisation lin = prepare_linearisation(problem, unknowns);
  if (!linearise(problem, unknowns, true, lin))
    throw std::runtime_error("an observation cannot be evaluated at the initial values (coinciding points?)");
  NormalEquations normal(lin, unknowns);
  normal.assemble(lin);
  InnerConstraints datum(normal, find_null_space(normal, options.rank_tolerance), options.datum_unknowns);
  Solution solution{std::move(unknowns), std::move(lin), std::move(normal), std::move(datum), {}, {}};
  solution.change = Eigen::VectorXd::Zero(solution.unknowns.count());
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
        const int unknown = lin.columns[static_cast<size_t>(block.column_begin + k)];
        const ParameterBlock& of = problem.parameters[static_cast<size_t>(s.unknowns.block_of(unknown))];
        if (of.plus) continue;
        const double digit = kLastDigit * of.value[static_cast<size_t>(s.unknowns.component_of(unknown))];
        sum += std::pow(jacobian(r, k) * digit, 2);
      }
  }
  return std::sqrt(sum);
}

/// One accepted step, damped as much as it needs. False if none lowers the sum of squares.
bool iterate(Problem& problem, Solution& s, double& damping, const SolverOptions& options) {
  for (;;) {
    const std::optional<Step> step = compute_step(s, damping);
    if (!step && damping == 0 && s.sums_of_squares.size() > 1)
      throw RankDefect("the system became singular during the iterations", Eigen::MatrixXd(s.unknowns.count(), 0));
    if (step) {
      const bool quadratic = step->length < 1e-2 * s.last_step;
      s.last_step = step->length;
      // Measured against the residuals too, so that a sum of squares near zero is still found to all its digits.
      const double negligible = options.negligible_step * std::min(1.0, std::sqrt(s.sum_of_squares()));
      if (damping == 0 && ((quadratic && step->length < negligible) || step->length < rounding(problem, s))) {
        s.converged = true;
        return false;
      }
      double rise = 0;
      const bool taken = try_step(problem, s, *step, rise);
      // Near the minimum the sum changes by less than its own rounding (each residual is known to about 1e-16 of the
      // observation, not of the residual): such a rise neither confirms nor refutes the step, and ends the search.
      const bool within_rounding = !taken && step->length < 1e-3 && rise < 1e-9 * std::max(1.0, s.sum_of_squares());
      s.converged = damping == 0 && (step->length < options.step_tolerance || within_rounding);
      if (taken) {
        damping = damping <= kFirstDamping ? 0.0 : 0.1 * damping;
        return true;
      }
      if (s.converged) return false;
    }
    damping = damping == 0 ? kFirstDamping : 10 * damping;
    if (damping > kLargestDamping) return false;
  }
}

}  // namespace

Solution solve(Problem& problem, const SolverOptions& options) {
  Solution s = start(problem, options);
  double damping = 0;
  while (s.iterations() < options.max_iterations && !s.converged) {
    stop_point();
    const bool taken = iterate(problem, s, damping, options);
    if (taken) {
      linearise(problem, s.unknowns, true, s.linearisation);
      s.normal.assemble(s.linearisation);
    }
    if (!taken) break;
  }
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
  if (!linearise(problem, solution.unknowns, true, solution.linearisation))
    throw std::runtime_error("an observation cannot be evaluated where a step leads");
  solution.normal.assemble(solution.linearisation);
}

}  // namespace plumbline::least_squares

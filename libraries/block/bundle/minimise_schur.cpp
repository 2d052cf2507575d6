// Levenberg-Marquardt (Marquardt 1963): damping in proportion to the diagonal, raised until the cost falls.
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "block/bundle/adjust.hpp"
#include "plumbline/stop.hpp"

namespace plumbline::bundle {
namespace {

double norm_of_values(const State& state) {
  double sum = 0;
  for (const auto& p : state.images) sum += p.position.squaredNorm() + 1;
  for (const auto& p : state.points) sum += p.squaredNorm();
  for (const auto& p : state.plates) sum += p.position.squaredNorm() + 1;
  for (const auto& i : state.interiors)
    for (double v : i) sum += v * v;
  return std::sqrt(sum);
}

}  // namespace

MinimiseSummary minimise_schur(const Problem& problem, State& state, const MinimiseOptions& options) {
  constexpr double first_damping = 1e-4, relief = 10, smallest_damping = 1e-12, largest_damping = 1e16;
  const Layout layout(problem);
  Elimination elimination(problem, layout, options.side, options.threads);
  MinimiseSummary summary;
  double damping = first_damping;
  if (!elimination.build(state, damping, options.loss))
    throw std::runtime_error(elimination.undefined() +
                             " cannot be computed from the approximate values: it lies behind the camera or outside "
                             "the camera model");
  double cost = summary.initial_cost = elimination.sum_of_squares();
  summary.message = "iteration limit";
  double growth = 2;
  State trial;
  while (summary.iterations < options.max_iterations) {
    stop_point();
    ++summary.iterations;
    Eigen::VectorXd step;
    bool usable = elimination.factorise({});
    double predicted = 0;
    if (usable) {
      step = elimination.step();
      predicted = step.dot(elimination.right()) + damping * step.cwiseAbs2().dot(elimination.diagonal());
      usable = step.allFinite();
    }
    if (usable && (predicted <= options.function_tolerance * cost ||
                   step.norm() <= options.step_tolerance * (norm_of_values(state) + options.step_tolerance))) {
      summary.converged = true;
      summary.message = "the next step would change nothing";
      break;
    }
    bool accepted = false;
    if (usable) {
      trial = state;
      apply_step(problem, layout, step, trial);
      // Linearised with the damping the next step would have: most steps are accepted, and then this is its system.
      const double next = std::max(damping / relief, smallest_damping);
      if (elimination.build(trial, next, options.loss) && elimination.sum_of_squares() < cost) {
        accepted = true;
        const double gain = cost - elimination.sum_of_squares();
        cost = elimination.sum_of_squares();
        std::swap(state, trial);
        damping = next;
        growth = 2;
        if (gain <= options.function_tolerance * cost) {
          summary.converged = true;
          summary.message = "the cost falls no further";
          break;
        }
      }
    }
    if (accepted) continue;
    damping *= growth;
    growth *= 2;
    if (damping > largest_damping) {
      summary.message = "no step lowers the cost";
      break;
    }
    elimination.build(state, damping, options.loss);
  }
  summary.final_cost = cost;
  return summary;
}

}  // namespace plumbline::bundle

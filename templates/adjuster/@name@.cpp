// adjust.@name@: bundle adjustment, free (4) or with control (5); stands in for adjust.schur (block.use=adjust.@name@).
//
// Write your way to the minimum into minimise(). Readers, approximate values, blunders, covariances and tests are those
// of every adjuster: nothing is taken from your own claim of convergence.
#include "photo/bundle/elimination.hpp"
#include "place/adjust/adjuster_node.hpp"
#include "plumbline/stop.hpp"

using namespace plumbline;
using namespace plumbline::bundle;

namespace {

struct Engine {
  /// Whether robust estimates are brought to the end by the project's own steps.
  static constexpr bool refines_robust = true;
  static constexpr Info info{"adjust.@name@", "adjuster", 1, "Bundle adjustment by damped Gauss-Newton steps"};

  /// Lowers the cost of the problem from `state`, in place. Here: Levenberg-Marquardt with a damping that is multiplied
  /// by ten until a step lowers the cost, and divided by ten when one does (Marquardt 1963).
  static MinimiseSummary minimise(const Problem& problem, State& state, const MinimiseOptions& options) {
    const Layout layout(problem);
    Elimination system(problem, layout, options.side, options.threads);
    double damping = 1e-4;
    if (!system.build(state, damping, options.loss))
      throw std::runtime_error(system.undefined() + " cannot be computed from the approximate values");
    MinimiseSummary summary;
    double cost = summary.initial_cost = system.sum_of_squares();
    summary.message = "iteration limit";
    while (summary.iterations++ < options.max_iterations && damping < 1e16) {
      stop_point();  // Ctrl-C ends the iteration here
      State trial = state;
      bool better = system.factorise({});
      if (better) {
        apply_step(problem, layout, system.step(), trial);
        better = system.build(trial, damping / 10, options.loss) && system.sum_of_squares() < cost;
      }
      if (better) {
        const double gain = cost - system.sum_of_squares();
        cost = system.sum_of_squares(), state = trial, damping = std::max(damping / 10, 1e-12);
        if ((summary.converged = gain <= options.function_tolerance * cost)) break;
      } else {
        damping *= 10;
        system.build(state, damping, options.loss);
      }
    }
    if (damping >= 1e16) summary.converged = true, summary.message = "no step lowers the cost";
    summary.final_cost = cost;
    return summary;
  }
};

}  // namespace

PLUMBLINE_PLUGIN("@name@", "0.1.0", "MIT", block::Adjuster<Engine>)

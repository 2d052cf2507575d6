// Levenberg-Marquardt (Marquardt 1963): damping in proportion to the diagonal, raised until the cost falls. Once a step
// is far shorter than the one before, those that follow keep its factors (Kelley 1995, Iterative Methods, 5.4: the
// chord method): the derivatives hardly change over the way that is left, and residuals are a fifth of the work.
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "photo/bundle/adjust.hpp"
#include "plumbline/stop.hpp"

namespace plumbline::bundle {
namespace {

constexpr double first_damping = 1e-4, relief = 100, smallest_damping = 1e-12, largest_damping = 1e16;
/// Of what the step before was to lower the cost by: below it steps with the same factors are tried, and go on.
constexpr double near = 0.03, still_near = 0.1;

double norm_of_values(const State& state) {
  double sum = 0;
  for (const auto& p : state.images) sum += p.position.squaredNorm() + 1;
  for (const auto& p : state.points) sum += p.squaredNorm();
  for (const auto& p : state.plates) sum += p.position.squaredNorm() + 1;
  for (const auto& i : state.interiors)
    for (double v : i) sum += v * v;
  return std::sqrt(sum);
}

constexpr double as_predicted = 0.9;  ///< of the fall that was predicted

class Descent {
 public:
  Descent(const Problem& problem, const Layout& layout, State& state, const MinimiseOptions& options)
      : problem_(problem),
        layout_(layout),
        options_(options),
        state_(state),
        elimination_(problem, layout, options.side, options.threads) {
    if (!elimination_.build(state, damping_, options.loss))
      throw std::runtime_error(elimination_.undefined() +
                               " cannot be computed from the approximate values: it lies behind the camera or outside "
                               "the camera model");
    cost_ = summary_.initial_cost = elimination_.sum_of_squares();
    summary_.message = "iteration limit";
  }

  MinimiseSummary run() {
    double before = 0;
    while (summary_.iterations < options_.max_iterations) {
      stop_point();
      ++summary_.iterations;
      const bool usable = compute_step();
      if (usable && is_negligible()) {
        converged("the next step would change nothing");
        break;
      }
      const double last = std::exchange(before, predicted_);
      if (usable && predicted_ < near * last) {
        if (settle()) break;
      } else if (usable && take_step()) {
        if (summary_.converged) break;
      } else if (!raise_damping()) {
        break;
      }
    }
    summary_.final_cost = cost_;
    return summary_;
  }

 private:
  bool compute_step() {
    predicted_ = 0;
    if (!elimination_.factorise({})) return false;
    step_ = elimination_.step();
    predicted_ = step_.dot(elimination_.right()) + damping_ * step_.cwiseAbs2().dot(elimination_.diagonal());
    return step_.allFinite();
  }

  double negligible() const { return options_.function_tolerance * cost_; }
  bool is_negligible() const {
    return predicted_ <= negligible() ||
           step_.norm() <= options_.step_tolerance * (norm_of_values(state_) + options_.step_tolerance);
  }

  void converged(const char* why) {
    summary_.converged = true;
    summary_.message = why;
  }

  /// False if the step does not lower the cost.
  bool take_step() {
    trial_ = state_;
    apply_step(problem_, layout_, step_, trial_);
    // Linearised with the damping the next step would have: most steps do what was predicted, and then this is its
    // system.
    const double expected = std::max(damping_ / relief, smallest_damping);
    if (!elimination_.build(trial_, expected, options_.loss) || !(elimination_.sum_of_squares() < cost_)) return false;
    const double gain = cost_ - elimination_.sum_of_squares(), ratio = gain / predicted_;
    cost_ = elimination_.sum_of_squares();
    std::swap(state_, trial_);
    // One that did less keeps its damping, or more (Nielsen 1999): without, a long weak block takes every second step
    // in vain.
    damping_ = ratio > as_predicted ? expected : std::max(expected, damping_ * (1 - std::pow(2 * ratio - 1, 3)));
    if (damping_ != expected) elimination_.build(state_, damping_, options_.loss);
    growth_ = 2;
    if (gain <= negligible()) converged("the cost falls no further");
    return true;
  }

  /// Steps with the factors at hand. True if that was all; else the system is that of where they led.
  bool settle() {
    Eigen::VectorXd right;
    for (int steps = 0; summary_.iterations < options_.max_iterations; ++steps) {
      trial_ = state_;
      apply_step(problem_, layout_, step_, trial_);
      double cost = 0;
      if (!elimination_.gradient(trial_, right, cost, options_.loss) || !(cost < cost_)) {
        if (steps == 0) return !raise_damping();
        break;
      }
      const double gain = cost_ - cost;
      std::swap(state_, trial_);
      cost_ = cost;
      step_ = elimination_.step(right);
      const double before = std::exchange(predicted_, step_.dot(right));
      if (gain <= negligible() || is_negligible()) {
        converged("the next step would change nothing");
        return true;
      }
      ++summary_.iterations;
      if (!(predicted_ < still_near * before)) break;
    }
    damping_ = std::max(damping_ / relief, smallest_damping);
    growth_ = 2;
    elimination_.build(state_, damping_, options_.loss);
    return false;
  }

  /// The system with more damping; false if there is no more.
  bool raise_damping() {
    damping_ *= growth_;
    growth_ *= 2;
    if (damping_ > largest_damping) {
      summary_.message = "no step lowers the cost";
      return false;
    }
    elimination_.build(state_, damping_, options_.loss);
    return true;
  }

  const Problem& problem_;
  const Layout& layout_;
  const MinimiseOptions& options_;
  State& state_;
  State trial_;
  Elimination elimination_;
  MinimiseSummary summary_;
  Eigen::VectorXd step_;
  double cost_ = 0, damping_ = first_damping, growth_ = 2;
  double predicted_ = 0;  ///< what `step_` should lower the cost by
};

}  // namespace

MinimiseSummary minimise_schur(const Problem& problem, State& state, const MinimiseOptions& options) {
  const Layout layout(problem);
  return Descent(problem, layout, state, options).run();
}

}  // namespace plumbline::bundle

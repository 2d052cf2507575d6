#include "least_squares/problem/descent.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "plumbline/stop.hpp"

namespace plumbline::least_squares {
namespace {

using Where = DampedSystem::Where;

constexpr double relief = 100;
/// Of what the step before was to lower the cost by: below it steps with the same factors are tried, and go on.
constexpr double near = 0.03, still_near = 0.1;
constexpr double as_predicted = 0.9;  ///< of the fall that was predicted

class Descent {
 public:
  Descent(DampedSystem& system, const DescentOptions& options)
      : system_(system), options_(options), cost_(system.cost()), damping_(options.first_damping) {
    summary_.initial_cost = cost_;
    summary_.message = "iteration limit";
  }

  DescentSummary run() {
    double before = 0;
    while (!summary_.converged && counted() < options_.max_iterations) {
      stop_point();
      ++summary_.iterations;
      const std::optional<double> predicted = system_.solve(damping_);
      if (predicted && system_.is_negligible(damping_)) {
        converged("the next step would change nothing");
        break;
      }
      predicted_ = predicted.value_or(0);
      refused_ += !predicted;
      const double last = std::exchange(before, predicted_);
      if (predicted && system_.has_chords() && predicted_ < near * last) {
        if (!settle()) break;
      } else if (!(predicted && take_step()) && !summary_.converged && !raise_damping()) {
        break;
      }
    }
    summary_.final_cost = cost_;
    summary_.damping = damping_;
    return summary_;
  }

 private:
  void converged(const char* why) {
    summary_.converged = true;
    summary_.message = why;
  }

  int counted() const { return summary_.iterations - (options_.counts_refused ? 0 : refused_); }

  double relieved() const {
    const double less = damping_ / relief;
    return less < options_.smallest_damping ? options_.rest_damping : less;
  }

  /// False if the step does not lower the cost; then the place has no system, unless that was all.
  bool take_step() {
    system_.try_step();
    // Linearised with the damping the next step would have: most steps do what was predicted, and then this is its
    // system.
    const double expected = relieved();
    const bool defined = system_.build(Where::trial, expected);
    const double gain = defined ? cost_ - system_.cost() : -std::numeric_limits<double>::infinity();
    const DampedSystem::Judgement judgement = system_.judge(gain, damping_);
    if (judgement.converged) converged("the cost falls no further");
    if (!judgement.taken) {
      system_.reject();
      if (judgement.converged) system_.build(Where::place, damping_);
      ++refused_;
      return false;
    }
    const double ratio = gain / predicted_;
    cost_ = system_.cost();
    system_.accept();
    // One that did less keeps its damping, or more (Nielsen 1999): without, a long weak block takes every second step
    // in vain.
    damping_ = ratio > as_predicted ? expected : std::max(expected, damping_ * (1 - std::pow(2 * ratio - 1, 3)));
    if (damping_ != expected) system_.build(Where::place, damping_);
    growth_ = 2;
    return true;
  }

  /// Steps with the factors at hand, until they get no smaller: then the system is that of where they led. False if
  /// that was all.
  bool settle() {
    for (int steps = 0; counted() < options_.max_iterations; ++steps) {
      system_.try_step();
      const std::optional<double> cost = system_.cost_of_trial();
      if (!cost || !(*cost < cost_)) {
        system_.reject();
        if (steps == 0) return raise_damping();
        break;
      }
      const double gain = cost_ - std::exchange(cost_, *cost);
      system_.accept();
      const double before = std::exchange(predicted_, system_.solve_again());
      if (system_.judge(gain, damping_).converged || system_.is_negligible(damping_)) {
        converged("the next step would change nothing");
        return false;
      }
      ++summary_.iterations;
      if (!(predicted_ < still_near * before)) break;
    }
    damping_ = relieved();
    growth_ = 2;
    system_.build(Where::place, damping_);
    return true;
  }

  /// The system with more damping; false if there is no more.
  bool raise_damping() {
    damping_ = damping_ == 0 ? options_.least_damping : damping_ * growth_;
    growth_ *= 2;
    if (damping_ > options_.largest_damping) summary_.message = "no step lowers the cost";
    system_.build(Where::place, damping_);
    return damping_ <= options_.largest_damping;
  }

  DampedSystem& system_;
  const DescentOptions& options_;
  DescentSummary summary_;
  double cost_, damping_, growth_ = 2;
  int refused_ = 0;       ///< steps that did not lower the cost
  double predicted_ = 0;  ///< what the step should lower the cost by
};

}  // namespace

DescentSummary descend(DampedSystem& system, const DescentOptions& options) { return Descent(system, options).run(); }

}  // namespace plumbline::least_squares

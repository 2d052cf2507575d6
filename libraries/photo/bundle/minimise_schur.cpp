// Image blocks on the damped loop of all adjustments, with chord steps: residuals are a fifth of the work.
#include <cmath>
#include <stdexcept>
#include <utility>

#include "least_squares/problem/descent.hpp"
#include "photo/bundle/adjust.hpp"

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

class BlockDescent : public least_squares::DampedSystem {
 public:
  BlockDescent(const Problem& problem, const Layout& layout, State& state, const MinimiseOptions& options)
      : problem_(problem),
        layout_(layout),
        options_(options),
        state_(state),
        elimination_(problem, layout, options.side, options.threads, options.reduced) {}

  bool build(Where where, double damping) override {
    const bool defined = elimination_.build(where == Where::place ? state_ : trial_, damping, options_.loss);
    (where == Where::place ? cost_ : trial_cost_) = elimination_.sum_of_squares();
    return defined;
  }
  double cost() const override { return elimination_.sum_of_squares(); }
  const std::string& undefined() const { return elimination_.undefined(); }
  long gradient_steps() const { return elimination_.gradient_steps(); }

  std::optional<double> solve(double damping) override {
    if (!elimination_.factorise({})) return std::nullopt;
    step_ = elimination_.step();
    predicted_ = step_.dot(elimination_.right()) + damping * step_.cwiseAbs2().dot(elimination_.diagonal());
    return step_.allFinite() ? std::optional(predicted_) : std::nullopt;
  }
  bool is_negligible(double) const override {
    return predicted_ <= options_.function_tolerance * cost_ ||
           step_.norm() <= options_.step_tolerance * (norm_of_values(state_) + options_.step_tolerance);
  }
  void try_step() override {
    trial_ = state_;
    apply_step(problem_, layout_, step_, trial_);
  }
  void accept() override {
    std::swap(state_, trial_);
    cost_ = trial_cost_;
  }
  void reject() override {}
  Judgement judge(double gain, double) const override {
    return {gain > 0, gain > 0 && gain <= options_.function_tolerance * (cost_ - gain)};
  }

  bool has_chords() const override { return true; }
  std::optional<double> cost_of_trial() override {
    return elimination_.gradient(trial_, right_, trial_cost_, options_.loss) ? std::optional(trial_cost_)
                                                                             : std::nullopt;
  }
  double solve_again() override {
    step_ = elimination_.step(right_);
    return predicted_ = step_.dot(right_);
  }

 private:
  const Problem& problem_;
  const Layout& layout_;
  const MinimiseOptions& options_;
  State& state_;
  State trial_;
  Elimination elimination_;
  Eigen::VectorXd step_, right_;
  double cost_ = 0, trial_cost_ = 0, predicted_ = 0;
};

}  // namespace

MinimiseSummary minimise_schur(const Problem& problem, State& state, const MinimiseOptions& options) {
  const Layout layout(problem);
  BlockDescent system(problem, layout, state, options);
  least_squares::DescentOptions how;
  how.max_iterations = options.max_iterations;
  if (!system.build(BlockDescent::Where::place, how.first_damping))
    throw std::runtime_error(system.undefined() +
                             " cannot be computed from the approximate values: it lies behind the camera or outside "
                             "the camera model");
  const least_squares::DescentSummary found = least_squares::descend(system, how);
  const std::string steps = system.gradient_steps() > 0
                                ? "; " + std::to_string(system.gradient_steps()) + " steps of conjugate gradients"
                                : "";
  return {found.converged, found.iterations, found.initial_cost, found.final_cost, found.message + steps};
}

}  // namespace plumbline::bundle

// The damped loop of every adjustment, networks and image blocks alike (Levenberg 1944, Marquardt 1963): damping in
// proportion to the diagonal of the normal matrix, raised until the sum of squares falls. What the unknowns are, how
// the system is linearised and factorised, and when a step is too short to matter, is its model's to know.
#pragma once

#include <optional>
#include <string>

namespace plumbline::least_squares {

/// A problem as the loop sees it: a place, and the linear system of the last build().
class DampedSystem {
 public:
  enum class Where { place, trial };
  struct Judgement {
    bool taken = false;      ///< the trial becomes the place
    bool converged = false;  ///< and that was the last step
  };

  virtual ~DampedSystem() = default;

  /// Linearises there. False if an observation is undefined there or not finite.
  virtual bool build(Where where, double damping) = 0;
  virtual double cost() const = 0;  ///< of the last build()
  /// The step from the place, and by how much it should lower the cost; nothing if there is no factor or the step is
  /// not finite. Precondition: build(place, damping), or build(trial, damping) and accept().
  virtual std::optional<double> solve(double damping) = 0;
  /// Whether the step of the last solve() would change nothing.
  virtual bool is_negligible(double damping) const = 0;
  virtual void try_step() = 0;  ///< the trial is where the step leads
  virtual void accept() = 0;    ///< the trial becomes the place
  virtual void reject() = 0;    ///< the place is as it was; its system is gone
  /// Of a trial that lowers the cost by `gain`; a rise, or minus infinity where it is undefined, is negative.
  virtual Judgement judge(double gain, double damping) const = 0;

  /// Steps with the factors at hand (Kelley 1995, Iterative Methods, 5.4: the chord method): the derivatives hardly
  /// change over the way that is left. Where they cost as much as others, there are none.
  virtual bool has_chords() const { return false; }
  virtual std::optional<double> cost_of_trial() { return std::nullopt; }  ///< and the right side there
  virtual double solve_again() { return 0; }                              ///< with that side: as solve()
};

struct DescentOptions {
  int max_iterations = 100;     ///< steps that are taken, or with `counts_refused` that are tried
  bool counts_refused = true;   ///< false: what is refused is bounded by the damping alone
  double first_damping = 1e-4;  ///< 0: undamped steps first
  double least_damping = 1e-4;  ///< that the first rise of the cost asks for
  /// Below `smallest_damping` it is `rest_damping`.
  double smallest_damping = 1e-12, rest_damping = 1e-12;
  double largest_damping = 1e16;
};

struct DescentSummary {
  bool converged = false;
  int iterations = 0;  ///< steps that were computed
  double initial_cost = 0, final_cost = 0;
  double damping = 0;  ///< of the system at hand
  std::string message;
};

/// From the place of `system`, which is built there with options.first_damping, to a minimum.
DescentSummary descend(DampedSystem& system, const DescentOptions& options);

}  // namespace plumbline::least_squares

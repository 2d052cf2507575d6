// Gauss-Newton with Levenberg-Marquardt damping when a step would raise the sum of squares: a rising v'Pv is never
// accepted.
#pragma once

#include <memory>
#include <vector>

#include "least_squares/problem/datum.hpp"
#include "least_squares/problem/normal_equations.hpp"
#include "least_squares/problem/problem.hpp"

namespace plumbline::least_squares {

struct Solution;

struct SolverOptions {
  /// Unknowns whose initial values define the datum where the observations leave one open (inner constraints).
  std::vector<int> datum_unknowns;
  int max_iterations = 100;
  /// Stop when |J dx| (the step in standard deviations of the observations) falls below this.
  double step_tolerance = 1e-7;
  /// With quadratic convergence a step below this is not taken any more: residuals, Jacobians and covariance then
  /// belong to one linearisation without another evaluation. 0: every step down to step_tolerance is taken.
  double negligible_step = 0;
  double rank_tolerance = 1e-9;  ///< eigenvalues of the scaled normal matrix below this are a defect
  /// A solution of nearly the same problem (an observation more or less, other weights), where this one starts: its
  /// pattern and order of elimination are used as far as they hold, and inner constraints stay relative to what they
  /// were there, if the unknowns are the same.
  const Solution* before = nullptr;
};

struct Solution {
  UnknownIndex unknowns;
  Linearisation linearisation;  ///< at the solution
  NormalEquations normal;       ///< at the solution
  InnerConstraints datum;
  Eigen::VectorXd change;               ///< x - x0 accumulated over all steps, one per unknown
  std::vector<double> sums_of_squares;  ///< v'Pv of the initial values and after each accepted step; never rises
  bool converged = false;
  double last_step = 0;  ///< |J dx| of the last step
  /// Of `normal` as it is, with the pinned unknowns of `datum`; null where none was made.
  std::shared_ptr<const SparseFactor> factor;

  int iterations() const { return static_cast<int>(sums_of_squares.size()) - 1; }
  double sum_of_squares() const { return linearisation.sum_of_squares; }
  int degrees_of_freedom() const { return linearisation.rows - unknowns.count() + datum.defect(); }
};

/// Changes the parameter values of `problem` to the least-squares solution. Throws RankDefect if the datum does not
/// complete the rank, std::runtime_error if the functions are undefined at the initial values. Not converging is told
/// in the result.
Solution solve(Problem& problem, const SolverOptions& options);

/// The undamped Gauss-Newton step from the current linearisation, in the datum of the solution; not taken. Throws
/// RankDefect if the normal matrix is singular there.
Eigen::VectorXd gauss_newton_step(Solution& solution);

/// Takes a step, wherever it leads, and linearises there. `problem` is the one that was solved. Throws
/// std::runtime_error if an observation is undefined there.
void move(Problem& problem, Solution& solution, const Eigen::VectorXd& step);

/// Qxx of all unknowns (n x n, a-priori variance of unit weight 1) in the datum of the solution. Symmetric to the bit.
/// Of large problems see cofactors.hpp.
Eigen::MatrixXd cofactor_matrix(const Solution& solution);

}  // namespace plumbline::least_squares

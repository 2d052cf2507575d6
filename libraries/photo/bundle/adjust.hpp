// From a block and its approximate values to the least-squares solution with everything that statistics need.
//
// Finding the minimum is one thing, and several programs can do it (Minimiser); what is said about the solution comes
// from one place: a few undamped Gauss-Newton steps under the datum finish it, and cofactors belong to the same normal
// equations. No engine's own claim of convergence is taken for a well-posed problem.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "least_squares/problem/reliability.hpp"
#include "photo/bundle/cofactors.hpp"

namespace plumbline::bundle {

struct MinimiseOptions {
  int max_iterations = 100;
  Loss loss;
  Side side = Side::automatic;
  int threads = 1;
  /// Stop when an iteration lowers the cost by less than this part of it, or moves no value by more than
  /// `step_tolerance` of the length of the vector of all values.
  double function_tolerance = 1e-12, step_tolerance = 1e-12;
  Reduced reduced = Reduced::factor;
};

struct MinimiseSummary {
  bool converged = false;
  int iterations = 0;
  double initial_cost = 0, final_cost = 0;  ///< Σ ρ of all observations
  std::string message;                      ///< of the engine
};

/// Lowers the cost of a problem from `state`, in place. Precondition: every observation can be computed there.
using Minimiser = std::function<MinimiseSummary(const Problem&, State&, const MinimiseOptions&)>;

/// Our own: Levenberg-Marquardt on Elimination. Throws std::runtime_error naming the observation that cannot be
/// computed at the start.
MinimiseSummary minimise_schur(const Problem& problem, State& state, const MinimiseOptions& options);

/// Ceres with the same analytic derivatives, DENSE_SCHUR, or SPARSE_SCHUR where the reduced system is large and sparse.
/// Single-threaded: with more its sums have another order.
MinimiseSummary minimise_ceres(const Problem& problem, State& state, const MinimiseOptions& options);

struct AdjustOptions {
  MinimiseOptions minimise;
  Minimiser minimiser = minimise_schur;
  Datum datum;  ///< of a free block, see free_motions()
  /// Undamped steps are tried first, the minimiser only where they lead nowhere.
  bool start_is_near = false;
  bool is_determined = false;  ///< somebody saw that all unknowns are
  /// The last linearisation is kept if no linear function of the unknowns moves by more than this many of its standard
  /// deviations from there to the minimum. 0: it is at the minimum.
  double nearby = 0;
  bool with_cofactors = true;  ///< Adjusted::cofactors is filled
  /// Told the memory that is going to be taken, before it is; may throw.
  std::function<void(std::size_t)> announce;
};

/// The block at its minimum. Owns nothing of problem and layout, which must outlive it.
struct Adjusted {
  State state;
  int iterations = 0;
  std::unique_ptr<Elimination> elimination;  ///< at the state, or AdjustOptions::nearby
  std::unique_ptr<Cofactors> cofactors;
  int rows = 0, unknowns = 0, defect = 0;
  int redundancy() const { return rows - unknowns + defect; }
  double sum_of_squares = 0;
};

/// Throws std::runtime_error that names what is undetermined (see require_determined()), or what kept the iteration
/// from converging: a motion or a combination of unknowns that the observations hardly fix, or the images and bodies at
/// which most of the misfit is, which is where a bad start shows.
Adjusted adjust(const Problem& problem, const Layout& layout, const State& start, const AdjustOptions& options);

/// The same by conjugate gradients, for blocks whose factor has no room: the minimum and nothing that is known of it.
/// `options.minimise.reduced` is taken as Reduced::gradients; datum, minimiser and announce count. Adjusted has no
/// cofactors. Of rank only this is seen: a point, plate, image or camera that is open by itself is named; a combination
/// of several is not noticed. Throws NotConverged if the minimiser says so, std::runtime_error as adjust() does.
Adjusted adjust_by_gradients(const Problem& problem, const Layout& layout, const State& start,
                             const AdjustOptions& options);

/// Takes adjusted.state to the minimum of a problem that has changed a little, weights by some percent, with the
/// factors there are. They stay as they were.
void follow(const Problem& problem, const Layout& layout, const AdjustOptions& options, Adjusted& adjusted);

/// Throws std::runtime_error if the linearised block is not of full rank: images whose pose and points whose position
/// is undetermined by name, similarity motions in words, any other null vector by the unknowns with the largest part in
/// it. Precondition: elimination.build() at `state` without damping. Leaves `elimination` factorised; false if rounding
/// leaves no Cholesky factor all the same.
bool require_determined(const Problem& problem, const Layout& layout, const State& state, Elimination& elimination,
                        const Datum& datum);

/// Statistics of every observation, held against Q_vv. Rows of image points, tags and distances by their index; known
/// coordinates row by row. Redundancy numbers, w and MDB for σ0 = 1; residuals in the unit of the observation.
struct Reliability {
  std::vector<std::array<least_squares::RowStatistics, 2>> points;
  std::vector<std::array<least_squares::RowStatistics, 8>> tags;
  std::vector<least_squares::RowStatistics> distances;
  std::vector<std::vector<least_squares::RowStatistics>> known;
  std::vector<least_squares::VarianceComponent> groups;  ///< one for each of problem.groups
};
Reliability reliability_of(const Problem& problem, const Adjusted& adjusted);

/// Variance component of all that is not in problem.known, taken as one group: as reliability_of() has it, from what
/// the known values leave of the redundancy. 0 if that is nothing.
double observed_variance(const Problem& problem, const Layout& layout, const Adjusted& adjusted, const Datum& datum);

}  // namespace plumbline::bundle

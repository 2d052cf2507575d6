// How well each observation is controlled by the others, and what an undetected blunder in it would do (Baarda 1968;
// Förstner 1987). With a-priori variance of unit weight 1:
//   redundancy number    r_i = (Qvv P)_ii,  sum over all rows = degrees of freedom
//   normalised residual  w_i = (P v)_i / sqrt((P Qvv P)_ii)
//   estimated blunder    -(P v)_i / (P Qvv P)_ii
//   minimal detectable   mdb_i = delta0 / sqrt((P Qvv P)_ii)   (diagonal P: delta0 sigma_i / sqrt(r_i))
//   external             dx = Qxx A' P e_i mdb_i
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "least_squares/problem/cofactors.hpp"
#include "least_squares/problem/problem.hpp"
#include "least_squares/problem/solver.hpp"

namespace plumbline::least_squares {

struct RowStatistics {
  double residual = 0;           ///< v = adjusted - observed, unit of the observation
  double sigma = 0;              ///< a priori, of the observation
  double sigma_adjusted = 0;     ///< of the adjusted observation
  double redundancy_number = 0;  ///< 0 (uncontrolled) .. 1; of correlated rows it may lie outside
  double controlled = 0;         ///< (P Qvv P)_ii / P_ii, 0 .. 1: what a row's own test sees; uncorrelated: r_i
  double w = 0;                  ///< normalised residual; 0 where uncontrolled
  double estimated_blunder = 0;  ///< NaN where uncontrolled
  double mdb = 0;                ///< minimal detectable blunder; infinity where uncontrolled
  double bias_to_noise = 0;      ///< mdb sqrt((P A Qxx A' P)_ii); uncorrelated: delta0 sqrt((1 - r) / r)
  /// Largest movement of a group of unknowns (a point) by a blunder of size mdb. Where the cofactors are not whole: of
  /// the groups that the row's own block connects, so that others may move farther.
  double external_effect = 0;
  int external_group = -1;  ///< which group that is
};

/// The same for the rows of one block that somebody else has linearised: whitening W (lower triangular, W'W =
/// covariance^-1), whitened residuals W v and their cofactors Quu; `delta0` is the non-centrality of the MDB. Without
/// external reliability. For correlated rows see Wang & Chen (1994).
std::vector<RowStatistics> row_statistics(const Eigen::Ref<const Eigen::MatrixXd>& whitening,
                                          const Eigen::Ref<const Eigen::VectorXd>& whitened_residuals,
                                          const Eigen::Ref<const Eigen::MatrixXd>& residual_cofactors, double delta0);

/// Joint test of the rows of one residual block: u' Quu^-1 u, chi-squared with `rank` degrees of freedom.
struct BlockTest {
  double statistic = 0;
  int rank = 0;
};

struct Reliability {
  std::vector<RowStatistics> rows;  ///< in the order of the residual blocks and their rows
  std::vector<BlockTest> blocks;
  double sum_of_redundancy_numbers = 0;
};

struct ReliabilityOptions {
  double alpha0 = 0.001;  ///< error of the first kind of one w-test, two-sided
  double power = 0.80;    ///< 1 - error of the second kind
  /// Groups of unknowns (the coordinates of a point; -1 for a constant one) for the external reliability; may be empty.
  std::vector<std::vector<int>> groups;
};

/// Rows that are `controlled` by less than this are taken as uncontrolled: w and blunder are numerically meaningless.
inline constexpr double kUncontrolled = 1e-6;

/// `cofactors` is Qxx of the solution.
Reliability compute_reliability(const Problem& problem, const Solution& solution, const Cofactors& cofactors,
                                const ReliabilityOptions& options);

/// Non-centrality of a one-dimensional w-test, e.g. 4.132 for alpha0 0.1 % and power 80 %.
double non_centrality(double alpha0, double power);

/// Critical value of |w| when the variance of unit weight is estimated with f degrees of freedom (tau test, Pope 1976).
double tau_critical(double alpha0, double degrees_of_freedom);

/// Two-sided test of v'Pv against chi-squared.
struct GlobalTest {
  enum class Verdict { low, pass, high };
  double statistic = 0, lower = 0, upper = 0;
  Verdict verdict = Verdict::pass;
};
GlobalTest global_test(double sum_of_squares, int degrees_of_freedom, double alpha);

/// Estimated factor of the a-priori variance of each group of rows (Förstner 1979): sum v_i (P v)_i / sum r_i.
struct VarianceComponent {
  std::string name;   ///< may be empty
  double factor = 1;  ///< stays 1 where there is no redundancy
  double sum_of_squares = 0, redundancy = 0;
  int rows = 0;
};
std::vector<VarianceComponent> variance_components(const Problem& problem, const Solution& solution,
                                                   const Reliability& reliability);

/// Axes of the standard ellipsoid of a 3x3 covariance, longest first; columns of `axes` are unit vectors.
struct ErrorEllipsoid {
  Eigen::Vector3d semi_axes;
  Eigen::Matrix3d axes;
};
ErrorEllipsoid error_ellipsoid(const Eigen::Matrix3d& covariance);
/// Factor from the standard to the confidence ellipsoid: 1.960, 2.448, 2.796 for 95 % in 1, 2, 3 dimensions.
double confidence_factor(double confidence, int dimensions);

}  // namespace plumbline::least_squares

// The chi-square statistic of many correlated errors, over the directions in which they can be tested at all.
#pragma once

#include <Eigen/Core>
#include <optional>

namespace plumbline::judgement {

/// d' C⁺ d over eigenvectors of C whose variance is above a limit, and how many these are.
struct TestedDirections {
  double statistic = 0;
  Eigen::Index number = 0;
};

/// `difference`: n [m]; `covariance`: n x n [m²], symmetric, worked on, and the same again afterwards; `limit` [m²]. By
/// Cholesky, a tenth of the time of eigenvalues: C - limit I has a factor if and only if no eigenvalue is at or below
/// the limit. `some_may_be_left_out`: a few that are, as an adjustment to surveyed control leaves where photographs
/// alone know nothing, are found by subspace iteration (Golub, Van Loan: Matrix Computations, 8.2.4) and taken out;
/// that there are no more of them is proved by a factor of the rest. Nothing where that does not do: few points, many
/// such directions, some hardly to be told from the others, numbers that are none.
std::optional<TestedDirections> tested_directions(const Eigen::VectorXd& difference, Eigen::MatrixXd& covariance,
                                                  double limit, bool some_may_be_left_out);

}  // namespace plumbline::judgement

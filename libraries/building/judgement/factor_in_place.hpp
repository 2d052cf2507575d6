// Cholesky factors of covariances that should not stand in memory twice: of 2400 points one has 415 MB.
#pragma once

#include <Eigen/Core>

namespace plumbline::judgement {

/// The factor L of a symmetric matrix, L Lᵀ, in its lower triangle; above the diagonal the matrix stays as it was.
/// False: it is not positive definite, and the lower triangle is of no use.
bool factor_in_place(Eigen::MatrixXd& symmetric);

/// What factor_in_place wrote over: the lower triangle from the upper one.
void restore_lower(const Eigen::VectorXd& diagonal, Eigen::MatrixXd& symmetric);

}  // namespace plumbline::judgement

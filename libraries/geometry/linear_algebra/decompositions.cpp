#include "geometry/linear_algebra/decompositions.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/QR>

namespace plumbline::linear_algebra {

using Eigen::MatrixXd;

SymmetricEigen::SymmetricEigen(const MatrixXd& matrix, int options) { compute(matrix, options); }

GeneralizedSymmetricEigen::GeneralizedSymmetricEigen(const MatrixXd& a, const MatrixXd& b, int options)
    : Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd>(a.rows()) {
  compute(a, b, options | Eigen::Ax_lBx);
}

SingularValues::SingularValues(const MatrixXd& matrix, unsigned options) { compute(matrix, options); }

MatrixXd compiled::minimum_norm_solution(const MatrixXd& a, const MatrixXd& right) {
  return a.completeOrthogonalDecomposition().solve(right);
}

MatrixXd pseudo_inverse(const MatrixXd& a) { return a.completeOrthogonalDecomposition().pseudoInverse(); }

MatrixXd compiled::least_squares_solution(const MatrixXd& a, const MatrixXd& right) {
  return a.colPivHouseholderQr().solve(right);
}

Eigen::VectorXi best_conditioned_rows(const MatrixXd& a) {
  return Eigen::ColPivHouseholderQR<MatrixXd>(a.transpose()).colsPermutation().indices().head(a.cols());
}

MatrixXd orthonormal_columns(const MatrixXd& a) {
  return Eigen::HouseholderQR<MatrixXd>(a).householderQ() * MatrixXd::Identity(a.rows(), a.cols());
}

MatrixXd compiled::solve(const MatrixXd& a, const MatrixXd& right) { return a.partialPivLu().solve(right); }

MatrixXd compiled::solve_symmetric(const MatrixXd& a, const MatrixXd& right) { return a.ldlt().solve(right); }

}  // namespace plumbline::linear_algebra

#pragma once

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <Eigen/SVD>

/// Decompositions of real matrices whose size is known when the program runs. They are Eigen's, instantiated once here:
/// a file that instantiates them itself costs the compiler 5 to 10 s more. Matrices of a fixed small size are Eigen's
/// own business.
namespace plumbline::linear_algebra {

/// Eigenvalues, ascending, and orthonormal eigenvectors of a symmetric n x n matrix, of which the lower triangle is
/// read.
class SymmetricEigen : public Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> {
 public:
  SymmetricEigen() = default;
  /// `options`: Eigen::ComputeEigenvectors, or Eigen::EigenvaluesOnly.
  explicit SymmetricEigen(const Eigen::MatrixXd& matrix, int options = Eigen::ComputeEigenvectors);
};

/// The same of A x = lambda B x, both symmetric n x n, B positive definite; the eigenvectors are B-orthonormal.
class GeneralizedSymmetricEigen : public Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> {
 public:
  GeneralizedSymmetricEigen(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b,
                            int options = Eigen::ComputeEigenvectors);
};

/// Singular values, descending, of an m x n matrix, and the vectors that `options` names (Eigen::ComputeThinU,
/// ComputeFullV, ...), by two-sided Jacobi rotations: small values keep their relative accuracy.
class SingularValues : public Eigen::JacobiSVD<Eigen::MatrixXd> {
 public:
  explicit SingularValues(const Eigen::MatrixXd& matrix, unsigned options = 0);
};

/// Moore and Penrose's inverse, n x m of m x n.
Eigen::MatrixXd pseudo_inverse(const Eigen::MatrixXd& a);

/// Rows of A^T by QR with column pivoting, the best conditioned first: numbers of rows of the m x n matrix `a`, n of
/// them.
Eigen::VectorXi best_conditioned_rows(const Eigen::MatrixXd& a);

/// Q of A = Q R: m x n with orthonormal columns, m >= n.
Eigen::MatrixXd orthonormal_columns(const Eigen::MatrixXd& a);

/// A matrix of unknowns, or a vector if the right side is one when the program is compiled.
template <typename Right>
using Unknowns = Eigen::Matrix<double, Eigen::Dynamic, Right::ColsAtCompileTime == 1 ? 1 : Eigen::Dynamic>;

namespace compiled {
Eigen::MatrixXd minimum_norm_solution(const Eigen::MatrixXd& a, const Eigen::MatrixXd& right);
Eigen::MatrixXd least_squares_solution(const Eigen::MatrixXd& a, const Eigen::MatrixXd& right);
Eigen::MatrixXd solve(const Eigen::MatrixXd& a, const Eigen::MatrixXd& right);
Eigen::MatrixXd solve_symmetric(const Eigen::MatrixXd& a, const Eigen::MatrixXd& right);
}  // namespace compiled

/// The x of least norm among those that make |A x - b| least, for every column b of `right`: A may have any rank. n x
/// k.
template <typename Right>
Unknowns<Right> minimum_norm_solution(const Eigen::MatrixXd& a, const Eigen::MatrixBase<Right>& right) {
  return compiled::minimum_norm_solution(a, right);
}

/// An x that makes |A x - b| least, by QR with column pivoting, for every column b of `right`.
template <typename Right>
Unknowns<Right> least_squares_solution(const Eigen::MatrixXd& a, const Eigen::MatrixBase<Right>& right) {
  return compiled::least_squares_solution(a, right);
}

/// A^-1 B of a regular A, by LU with row pivoting.
template <typename Right>
Unknowns<Right> solve(const Eigen::MatrixXd& a, const Eigen::MatrixBase<Right>& right) {
  return compiled::solve(a, right);
}

/// A^-1 B of a symmetric A that is positive definite or nearly so, by L D L^T with pivoting; the lower triangle is
/// read.
template <typename Right>
Unknowns<Right> solve_symmetric(const Eigen::MatrixXd& a, const Eigen::MatrixBase<Right>& right) {
  return compiled::solve_symmetric(a, right);
}

}  // namespace plumbline::linear_algebra

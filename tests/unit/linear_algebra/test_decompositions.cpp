// Each decomposition by what defines it, on matrices that are not square, not of full rank or not definite.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <numbers>

#include "geometry/linear_algebra/decompositions.hpp"
#include "geometry/random.hpp"
#include "geometry/similarity.hpp"

namespace plumbline::linear_algebra {
namespace test_decompositions {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

MatrixXd drawn(Eigen::Index rows, Eigen::Index columns, std::uint64_t seed) {
  Random random(seed);
  return MatrixXd::NullaryExpr(rows, columns, [&] { return random.uniform(-1, 1); });
}

/// 6 x 4 of rank 2.
MatrixXd deficient() { return drawn(6, 2, 1) * drawn(2, 4, 2); }

TEST(Decompositions, EigenvaluesAreAscendingAndTheirVectorsGiveTheMatrixBack) {
  const MatrixXd half = drawn(5, 5, 3), matrix = half + half.transpose();
  const SymmetricEigen eigen(matrix);
  EXPECT_LT(
      (eigen.eigenvectors() * eigen.eigenvalues().asDiagonal() * eigen.eigenvectors().transpose() - matrix).norm(),
      1e-12);
  EXPECT_LT((eigen.eigenvectors().transpose() * eigen.eigenvectors() - MatrixXd::Identity(5, 5)).norm(), 1e-12);
  for (int k = 1; k < 5; ++k) EXPECT_LE(eigen.eigenvalues()[k - 1], eigen.eigenvalues()[k]);
  EXPECT_EQ(SymmetricEigen(matrix, Eigen::EigenvaluesOnly).eigenvalues().size(), 5);
  MatrixXd lower = matrix;
  lower.triangularView<Eigen::StrictlyUpper>().setConstant(7);
  EXPECT_EQ(SymmetricEigen(lower).eigenvalues(), eigen.eigenvalues());
}

TEST(Decompositions, GeneralizedEigenvaluesAreThoseOfThePair) {
  const MatrixXd half = drawn(4, 4, 4), a = half + half.transpose(),
                 b = half * half.transpose() + MatrixXd::Identity(4, 4);
  const GeneralizedSymmetricEigen eigen(a, b);
  EXPECT_LT((a * eigen.eigenvectors() - b * eigen.eigenvectors() * eigen.eigenvalues().asDiagonal()).norm(), 1e-12);
  EXPECT_LT((eigen.eigenvectors().transpose() * b * eigen.eigenvectors() - MatrixXd::Identity(4, 4)).norm(), 1e-12);
}

TEST(Decompositions, SingularValuesTellTheRank) {
  const SingularValues svd(deficient(), Eigen::ComputeFullU | Eigen::ComputeFullV);
  ASSERT_EQ(svd.singularValues().size(), 4);
  EXPECT_GT(svd.singularValues()[1], 1e-2);
  EXPECT_LT(svd.singularValues()[2], 1e-14);
  EXPECT_LT((deficient() * svd.matrixV().rightCols(2)).norm(), 1e-14);
  EXPECT_LT(
      (svd.matrixU().leftCols(4) * svd.singularValues().asDiagonal() * svd.matrixV().transpose() - deficient()).norm(),
      1e-14);
}

TEST(Decompositions, OfAllBestSolutionsTheShortestIsTaken) {
  const MatrixXd a = deficient(), right = drawn(6, 3, 5), x = minimum_norm_solution(a, right);
  EXPECT_LT((a.transpose() * (a * x - right)).norm(), 1e-13);  // normal equations
  EXPECT_LT((SingularValues(a, Eigen::ComputeFullV).matrixV().rightCols(2).transpose() * x).norm(), 1e-13);
}

TEST(Decompositions, ThePseudoInverseHasPenrosesFourProperties) {
  const MatrixXd a = deficient(), p = pseudo_inverse(a), ap = a * p, pa = p * a;
  EXPECT_LT((ap * a - a).norm(), 1e-13);
  EXPECT_LT((pa * p - p).norm(), 1e-11);
  EXPECT_LT((ap - ap.transpose()).norm(), 1e-13);
  EXPECT_LT((pa - pa.transpose()).norm(), 1e-13);
}

TEST(Decompositions, LeastSquaresLeavesNothingAlongTheColumns) {
  const MatrixXd a = drawn(7, 3, 6), right = drawn(7, 2, 7);
  EXPECT_LT((a.transpose() * (a * least_squares_solution(a, right) - right)).norm(), 1e-13);
}

TEST(Decompositions, RowsThatAreChosenAreIndependent) {
  MatrixXd a = drawn(6, 2, 8);
  a.row(3) *= 10;
  a.row(1) = 0.9 * a.row(3);  // large, and along the largest
  const Eigen::VectorXi rows = best_conditioned_rows(a);
  ASSERT_EQ(rows.size(), 2);
  EXPECT_EQ(rows[0], 3);
  EXPECT_NE(rows[1], 1);
}

TEST(Decompositions, OrthonormalColumnsSpanTheSame) {
  const MatrixXd a = drawn(6, 3, 9), q = orthonormal_columns(a);
  ASSERT_EQ(q.cols(), 3);
  EXPECT_LT((q.transpose() * q - MatrixXd::Identity(3, 3)).norm(), 1e-13);
  EXPECT_LT((a - q * (q.transpose() * a)).norm(), 1e-13);
}

TEST(Decompositions, SolveRegularAndSymmetricSystems) {
  const MatrixXd a = drawn(5, 5, 10), s = a * a.transpose() + MatrixXd::Identity(5, 5), right = drawn(5, 2, 11);
  EXPECT_LT((a * solve(a, right) - right).norm(), 1e-12);
  EXPECT_LT((s * solve_symmetric(s, right) - right).norm(), 1e-12);
  MatrixXd lower = s;
  lower.triangularView<Eigen::StrictlyUpper>().setConstant(7);
  EXPECT_EQ(solve_symmetric(lower, right), solve_symmetric(s, right));
}

TEST(ShortestRotation, TakesOneDirectionToTheOtherByTheLeastAngle) {
  Random random(12);
  for (int k = 0; k < 100; ++k) {
    const auto draw = [&] { return Vector3d(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)); };
    const Vector3d from = draw(), to = draw();
    const Eigen::Quaterniond turn = shortest_rotation(from, to);
    EXPECT_NEAR(turn.norm(), 1, 1e-14);
    EXPECT_LT((turn * from.normalized() - to.normalized()).norm(), 1e-13);
    EXPECT_NEAR(turn.vec().dot(from), 0, 1e-14);
    EXPECT_GE(turn.w(), 0);
  }
}

TEST(ShortestRotation, OfOppositeDirectionsIsHalfATurnAcrossThem) {
  for (const Vector3d& from : {Vector3d(0, 0, 2), Vector3d(1, 2, 3), Vector3d(-1, 0, 0)}) {
    const Eigen::Quaterniond turn = shortest_rotation(from, -from);
    EXPECT_LT((turn * from + from).norm(), 1e-12);
    EXPECT_NEAR(Eigen::AngleAxisd(turn).angle(), std::numbers::pi, 1e-12);
  }
}

}  // namespace test_decompositions
}  // namespace plumbline::linear_algebra

// The Cholesky factor by blocks against Eigen's, at every size: what is left over at the end of a block is another case
// each time.
#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "geometry/random.hpp"
#include "least_squares/sparse/dense_cholesky.hpp"

namespace test_dense_cholesky {

using namespace plumbline;

Eigen::MatrixXd random_matrix(Eigen::Index rows, Eigen::Index columns, uint64_t seed) {
  Random random(seed);
  return Eigen::MatrixXd::NullaryExpr(rows, columns, [&] { return random.normal(); });
}

double difference(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) { return (a - b).cwiseAbs().maxCoeff(); }

TEST(Cholesky, IsThatOfEigenAtEverySize) {
  for (Eigen::Index n = 1; n <= 140; ++n) {
    SCOPED_TRACE(n);
    const Eigen::MatrixXd root = random_matrix(n, n, static_cast<uint64_t>(n));
    const Eigen::MatrixXd matrix = root * root.transpose() + double(n) * Eigen::MatrixXd::Identity(n, n);
    const Eigen::LLT<Eigen::MatrixXd> expected(matrix);
    const Eigen::MatrixXd lower = expected.matrixL(), identity = Eigen::MatrixXd::Identity(n, n);
    least_squares::Cholesky factor;
    ASSERT_TRUE(factor.compute(matrix));
    EXPECT_LT(difference(factor.inverse_factor(), lower.triangularView<Eigen::Lower>().solve(identity)), 1e-13);
    const Eigen::MatrixXd inverse = expected.solve(identity);
    EXPECT_LT(difference(factor.inverse(), inverse), 1e-13);
    EXPECT_LT(difference(factor.inverse(n / 3), inverse.bottomRightCorner(n - n / 3, n - n / 3)), 1e-13);
    const Eigen::MatrixXd right = random_matrix(n, 1 + n % 7, 1000);
    Eigen::MatrixXd whole = right, half = right;
    Eigen::VectorXd single = right.col(0);
    factor.solve_in_place(whole);
    factor.half_solve_in_place(half);
    factor.solve_in_place(single);
    EXPECT_LT(difference(whole, inverse * right), 1e-13);
    EXPECT_LT(difference(half, lower.triangularView<Eigen::Lower>().solve(right)), 1e-12);
    EXPECT_LT(difference(single, inverse * right.col(0)), 1e-13);
  }
}

TEST(Cholesky, RefusesWhatIsNotPositiveDefinite) {
  for (Eigen::Index at : {0, 17, 31, 32, 70}) {
    Eigen::MatrixXd matrix = Eigen::MatrixXd::Identity(71, 71);
    least_squares::Cholesky factor;
    for (double bad : {0.0, -1.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
      matrix(at, at) = bad;
      EXPECT_FALSE(factor.compute(matrix)) << at << " " << bad;
    }
  }
}

}  // namespace test_dense_cholesky

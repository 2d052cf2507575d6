// The least-squares core on small problems whose answers are known by other means: dense formulas, published values,
// symmetry.
#include <Eigen/Dense>
#include <cmath>

#include "least_squares/problem/reliability.hpp"
#include "least_squares/problem/solver.hpp"
#include "small_problems.hpp"
#include "test_support.hpp"

namespace plumbline::least_squares {
namespace test_adjustment {

using namespace small;

TEST(Adjustment, LinearModelWithFullCovarianceEqualsTheDenseFormula) {
  Eigen::MatrixXd a(6, 2);
  a << 1, 0, 1, 1, 1, 2, 1, 3, 1, 4, 1, 5;
  Eigen::VectorXd l(6);
  l << 1.1, 2.9, 5.2, 7.1, 8.8, 11.3;
  Eigen::MatrixXd c = 0.04 * Eigen::MatrixXd::Identity(6, 6);
  for (int i = 0; i + 1 < 6; ++i) c(i, i + 1) = c(i + 1, i) = 0.015;
  Problem problem = linear_problem(a, l, c);
  const Solution s = solve(problem, {});
  const Eigen::MatrixXd p = c.inverse();
  const Eigen::MatrixXd q = (a.transpose() * p * a).inverse();
  const Eigen::VectorXd x = q * a.transpose() * p * l, v = a * x - l;
  ASSERT_TRUE(s.converged);
  EXPECT_NEAR(problem.parameters[0].value[0], x[0], 1e-12);
  EXPECT_NEAR(problem.parameters[0].value[1], x[1], 1e-12);
  EXPECT_LT((cofactor_matrix(s) - q).norm(), 1e-14);
  EXPECT_NEAR(s.sum_of_squares(), v.dot(p * v), 1e-10);

  const Reliability rel = compute_reliability(problem, s, Cofactors(s), {});
  const Eigen::MatrixXd qvv = c - a * q * a.transpose(), pqp = p * qvv * p;
  for (int i = 0; i < 6; ++i) {
    EXPECT_NEAR(rel.rows[i].redundancy_number, (qvv * p)(i, i), 1e-12);
    EXPECT_NEAR(rel.rows[i].w, (p * v)[i] / std::sqrt(pqp(i, i)), 1e-10);
    EXPECT_NEAR(rel.rows[i].mdb, 4.1319 / std::sqrt(pqp(i, i)), 1e-4);
    EXPECT_NEAR(rel.rows[i].residual, v[i], 1e-12);
  }
  EXPECT_NEAR(rel.sum_of_redundancy_numbers, 4, 1e-12);
  EXPECT_EQ(rel.blocks[0].rank, 4);  // the residuals of the only block have the rank of the whole redundancy
}

TEST(Adjustment, FreeNetworkEqualsThePseudoInverse) {
  Problem problem = trilateration();
  SolverOptions options;
  options.datum_unknowns = all_unknowns(8);
  const Solution s = solve(problem, options);
  ASSERT_TRUE(s.converged);
  EXPECT_EQ(s.datum.defect(), 3);
  EXPECT_EQ(s.degrees_of_freedom(), 1);
  // Dense: N+ of the unscaled normal matrix is the cofactor matrix of total trace minimum (Mittermayer 1972). The
  // constraints are those of the initial values, so the comparison starts at the solution.
  const Solution again = solve(problem, options);
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(6, 8);
  for (const auto& block : again.linearisation.blocks)
    for (int k = 0; k < block.column_count; ++k)
      a(block.row, again.linearisation.columns[block.column_begin + k]) = again.linearisation.jacobian_of(block)(0, k);
  const Eigen::MatrixXd n = a.transpose() * a;
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> decomposition;
  decomposition.setThreshold(1e-10);
  decomposition.compute(n);
  const Eigen::MatrixXd pseudo = decomposition.pseudoInverse();
  EXPECT_LT((cofactor_matrix(again) - pseudo).cwiseAbs().maxCoeff(), 1e-9 * pseudo.cwiseAbs().maxCoeff());
  const Reliability rel = compute_reliability(problem, again, Cofactors(pseudo), {});
  for (size_t b = 0; b < rel.blocks.size(); ++b) {  // a block of one row is tested as the row is
    EXPECT_EQ(rel.blocks[b].rank, 1);
    EXPECT_NEAR(rel.blocks[b].statistic, rel.rows[b].w * rel.rows[b].w, 1e-9);
  }
}

TEST(Adjustment, InnerConstraintsStayRelativeToTheInitialValues) {
  Problem problem = trilateration(0.5);
  std::vector<double> before;
  for (const auto& p : problem.parameters) before.insert(before.end(), p.value.begin(), p.value.end());
  SolverOptions options;
  options.datum_unknowns = all_unknowns(8);
  const Solution s = solve(problem, options);
  double east = 0, north = 0, turn = 0;
  for (int i = 0; i < 4; ++i) {
    const auto& now = problem.parameters[i].value;
    const double de = now[0] - before[2 * i], dn = now[1] - before[2 * i + 1];
    east += de;
    north += dn;
    turn += before[2 * i + 1] * de - before[2 * i] * dn;
  }
  EXPECT_GT(s.iterations(), 2);
  EXPECT_NEAR(east, 0, 1e-10);
  EXPECT_NEAR(north, 0, 1e-10);
  EXPECT_NEAR(turn, 0, 1e-7);
}

TEST(Adjustment, STransformationLeadsToTheCofactorsOfTheOtherDatum) {
  SolverOptions all, two;
  all.datum_unknowns = all_unknowns(8);
  two.datum_unknowns = {0, 1, 2, 3};
  Problem first = trilateration();
  solve(first, all);
  const Solution a = solve(first, all), b = solve(first, two);
  const Eigen::MatrixXd moved = s_transform(cofactor_matrix(a), a.datum.null_space(), two.datum_unknowns);
  EXPECT_LT((moved - cofactor_matrix(b)).cwiseAbs().maxCoeff(), 1e-9 * moved.cwiseAbs().maxCoeff());
}

TEST(Adjustment, MissingDatumNamesTheOpenDirections) {
  Problem problem = trilateration();
  try {
    solve(problem, {});
    FAIL() << "a free network without datum was accepted";
  } catch (const RankDefect& defect) {
    EXPECT_EQ(defect.directions.cols(), 3);
  }
  SolverOptions one_point;
  one_point.datum_unknowns = {0, 1};
  try {
    solve(problem, one_point);
    FAIL() << "one point cannot hold a rotation";
  } catch (const RankDefect& defect) {
    // P0 is held: only the rotation about it is left, or directions that contain it.
    EXPECT_GE(defect.directions.cols(), 1);
  }
}

TEST(Adjustment, UnobservedUnknownIsADefect) {
  Problem problem = trilateration();
  problem.parameters.push_back({"lonely", {1.0}, {}});
  SolverOptions options;
  options.datum_unknowns = all_unknowns(8);
  try {
    solve(problem, options);
    FAIL() << "an unknown without observation was accepted";
  } catch (const RankDefect& defect) {
    ASSERT_EQ(defect.directions.cols(), 1);
    EXPECT_NEAR(std::abs(defect.directions(8, 0)), 1, 1e-6);
    EXPECT_LT(defect.directions.topRows(8).cwiseAbs().maxCoeff(), 1e-6);
  }
}

Problem growth() {
  Problem problem;
  problem.parameters.push_back({"k", {-3.0}, {}});
  for (int t = 1; t <= 5; ++t) {
    auto block = std::make_unique<ExponentialResidual>(t, std::exp(0.7 * t));
    block->set_sigmas(Eigen::VectorXd::Constant(1, 0.1));
    block->parameters = {0};
    problem.residuals.push_back(std::move(block));
  }
  return problem;
}

/// The limit is one of steps that are taken: those that were tried with too little damping do not use it up.
TEST(Adjustment, RefusedStepsAreNoIterations) {
  Problem problem = growth();
  const int taken = solve(problem, {}).iterations();
  problem = growth();
  SolverOptions options;
  options.max_iterations = taken + 1;  // and one that finds that there is nothing left
  EXPECT_TRUE(solve(problem, options).converged);
  problem = growth();
  options.max_iterations = taken / 2;
  const Solution half = solve(problem, options);
  EXPECT_FALSE(half.converged);
  EXPECT_EQ(half.iterations(), taken / 2);
}

TEST(Adjustment, NeverAcceptsARisingSumOfSquares) {
  Problem problem = growth();
  const Solution s = solve(problem, {});
  for (size_t k = 1; k < s.sums_of_squares.size(); ++k) EXPECT_LE(s.sums_of_squares[k], s.sums_of_squares[k - 1]);
  EXPECT_TRUE(s.converged);
  EXPECT_NEAR(problem.parameters[0].value[0], 0.7, 1e-9);
}

TEST(Adjustment, ConstantComponentsAreNoUnknowns) {
  Problem problem = trilateration();
  problem.parameters[0].constant = {true, true};
  problem.parameters[1].constant = {false, true};
  const Solution s = solve(problem, {});
  EXPECT_EQ(s.unknowns.count(), 5);
  EXPECT_EQ(s.datum.defect(), 0);
  EXPECT_EQ(problem.parameters[0].value[0], 0.0);
  EXPECT_EQ(problem.parameters[1].value[1], 0.0);
  const Reliability rel = compute_reliability(problem, s, Cofactors(s), {});
  EXPECT_NEAR(rel.sum_of_redundancy_numbers, 1, 1e-9);
}

TEST(Adjustment, CriticalValuesOfTheField) {
  EXPECT_NEAR(non_centrality(0.001, 0.8), 4.132, 1e-3);
  EXPECT_NEAR(non_centrality(0.05, 0.8), 2.802, 1e-3);
  EXPECT_NEAR(non_centrality(0.01, 0.8), 3.418, 1e-3);
  EXPECT_NEAR(confidence_factor(0.95, 1), 1.960, 1e-3);
  EXPECT_NEAR(confidence_factor(0.95, 2), 2.448, 1e-3);
  EXPECT_NEAR(confidence_factor(0.95, 3), 2.796, 1e-3);
  EXPECT_NEAR(global_test(50, 47, 0.05).lower, 29.96, 5e-3);
  EXPECT_NEAR(global_test(50, 47, 0.05).upper, 67.82, 5e-3);
  EXPECT_EQ(global_test(10, 47, 0.05).verdict, GlobalTest::Verdict::low);
  EXPECT_EQ(global_test(90, 47, 0.05).verdict, GlobalTest::Verdict::high);
  EXPECT_NEAR(tau_critical(0.05, 10), std::sqrt(10.0) * 2.262157 / std::sqrt(9 + 2.262157 * 2.262157), 1e-5);
}

/// Of a covariance that is rotated and has three different axes, its axes and not their complements come back.
TEST(Adjustment, AxesOfTheErrorEllipsoidPointAlongTheErrors) {
  const Eigen::Matrix3d turn =
      (Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitX()) * Eigen::AngleAxisd(-1.1, Eigen::Vector3d::UnitY()) *
       Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ()))
          .toRotationMatrix();
  const Eigen::Vector3d sigma(5, 2, 0.5);  // along the columns of `turn`
  const Eigen::Matrix3d covariance = turn * sigma.cwiseAbs2().asDiagonal() * turn.transpose();
  const ErrorEllipsoid ellipsoid = error_ellipsoid(covariance);
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(ellipsoid.semi_axes[k], sigma[k], 1e-12) << k;
    EXPECT_NEAR(std::abs(ellipsoid.axes.col(k).dot(turn.col(k))), 1, 1e-12) << k;
    // Along its axis the standard deviation is the semi-axis: from the covariance itself.
    EXPECT_NEAR(std::sqrt(ellipsoid.axes.col(k).dot(covariance * ellipsoid.axes.col(k))), ellipsoid.semi_axes[k],
                1e-12);
  }
}

/// A refused step leaves nothing behind: values, residuals and their sum are those of before. A slope of the wrong sign
/// makes every step rise.
TEST(Adjustment, ARefusedStepLeavesEverythingAsItWas) {
  class WrongSlope : public ResidualBlock {
   public:
    bool evaluate(const double* const* values, double* residuals, double* const* jacobians) const override {
      residuals[0] = values[0][0] - 5, residuals[1] = 2 * values[0][0] - 11;
      if (jacobians[0]) jacobians[0][0] = -1, jacobians[0][1] = -2;
      return true;
    }
  };
  Problem problem;
  problem.parameters.push_back({"x", {3.0}, {}});
  auto block = std::make_unique<WrongSlope>();
  block->set_sigmas(Eigen::Vector2d(0.5, 0.5));
  block->parameters = {0};
  problem.residuals.push_back(std::move(block));
  const Solution s = solve(problem, {});
  EXPECT_FALSE(s.converged);
  EXPECT_EQ(s.sums_of_squares.size(), 1u) << "none was taken";
  EXPECT_EQ(problem.parameters[0].value[0], 3.0);
  ASSERT_EQ(s.linearisation.residuals.size(), 2);
  EXPECT_NEAR(s.linearisation.residuals(0), -4, 1e-12) << "whitened: (3 - 5) / 0.5";
  EXPECT_NEAR(s.linearisation.residuals(1), -10, 1e-12);
  EXPECT_NEAR(s.sum_of_squares(), 116, 1e-12);
}

TEST(Adjustment, SigmasAndCovariancesAreChecked) {
  LinearResidual block(Eigen::MatrixXd::Ones(2, 1), Eigen::Vector2d(1, 2));
  EXPECT_THROW(block.set_sigmas(Eigen::Vector2d(1, 0)), std::invalid_argument);
  EXPECT_THROW(block.set_sigmas(Eigen::Vector2d(1, NAN)), std::invalid_argument);
  Eigen::Matrix2d c;
  c << 1, 2, 2, 1;
  EXPECT_THROW(block.set_covariance(c), std::invalid_argument);
  c << 1, 0.2, 0.1, 1;
  EXPECT_THROW(block.set_covariance(c), std::invalid_argument);
  EXPECT_THROW(block.set_covariance(1e-6 * c), std::invalid_argument) << "in metres as in millimetres";
}

}  // namespace test_adjustment
}  // namespace plumbline::least_squares

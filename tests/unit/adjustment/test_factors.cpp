// Inverses and cofactors from the factor, and what goes on from it.
#include <Eigen/Dense>
#include <cmath>

#include "least_squares/problem/marginal.hpp"
#include "least_squares/problem/reliability.hpp"
#include "least_squares/problem/solver.hpp"
#include "small_problems.hpp"
#include "test_support.hpp"

namespace plumbline::least_squares {
namespace test_factors {

using namespace small;

TEST(Adjustment, SparseInverseEqualsTheDenseInverse) {
  // Long enough for several batches of right sides, with pins and a shift.
  const int n = 161;
  Problem problem = chain(n);
  const UnknownIndex unknowns(problem);
  Linearisation lin = prepare_linearisation(problem, unknowns);
  ASSERT_TRUE(linearise(problem, unknowns, true, lin));
  NormalEquations normal(lin, unknowns);
  normal.assemble(lin);
  ASSERT_FALSE(normal.analysis()->is_dense());
  SparseFactor factor;
  ASSERT_TRUE(factor.factorise(normal, 1e-3, {4, 17}));
  Eigen::MatrixXd dense = normal.multiply_scaled(Eigen::MatrixXd::Identity(n, n));
  EXPECT_LT((dense.diagonal().array() - 1).abs().maxCoeff(), 1e-14);
  for (int p : {4, 17}) {
    dense.row(p).setZero();
    dense.col(p).setZero();
    dense(p, p) = 1;
  }
  dense.diagonal().array() += 1e-3;
  EXPECT_LT((factor.inverse() * dense - Eigen::MatrixXd::Identity(n, n)).cwiseAbs().maxCoeff(), 1e-9);
  const Eigen::MatrixXd b = Eigen::MatrixXd::Random(n, 11);
  EXPECT_LT((dense * factor.solve(b) - b).cwiseAbs().maxCoeff(), 1e-9);
}

/// Everything that is asked of cofactors is the same whether they are whole or not, in a free network too.
TEST(Adjustment, CofactorsOnDemandAreThoseOfTheWhole) {
  for (const bool free : {true, false}) {
    Problem problem = free ? trilateration() : chain(161);
    SolverOptions options;
    if (free) {
      // As often as makes it sparse: squares side by side, the corner of each tied to the next by distances.
      problem = Problem{};
      const int squares = 30;
      const auto add_distance = [&](int from, int to) {
        const auto &a = problem.parameters[from].value, &b = problem.parameters[to].value;
        auto block =
            std::make_unique<DistanceResidual>(std::hypot(a[0] - b[0], a[1] - b[1]) + 1e-4 * ((from + to) % 3));
        block->set_sigmas(Eigen::VectorXd::Constant(1, 0.001 * (1 + (from + to) % 4)));
        block->parameters = {from, to};
        problem.residuals.push_back(std::move(block));
      };
      for (int i = 0; i <= squares; ++i)
        for (int k = 0; k < 2; ++k) {
          problem.parameters.push_back({"P", {10.0 * i + 0.3 * k, 10.0 * k + 0.2 * (i % 3)}, {}});
          const int last = static_cast<int>(problem.parameters.size()) - 1;
          for (int before = std::max(0, last - 3 - k); before < last; ++before) add_distance(before, last);
        }
      for (int u = 0; u < 20; ++u) options.datum_unknowns.push_back(u);
    } else {
      for (int at : {0, 160}) {
        auto block = std::make_unique<LinearResidual>(Eigen::MatrixXd::Ones(1, 1), Eigen::VectorXd::Ones(1));
        block->set_sigmas(Eigen::VectorXd::Constant(1, 0.1));
        block->parameters = {at};
        problem.residuals.push_back(std::move(block));
      }
    }
    const Solution s = solve(problem, options);
    ASSERT_EQ(s.datum.defect(), free ? 3 : 0);
    const Cofactors whole(s), sparse(s, 10);
    ASSERT_TRUE(whole.is_whole());
    ASSERT_FALSE(sparse.is_whole());
    const Eigen::MatrixXd& q = whole.whole();
    const int n = sparse.size();
    const double size = q.cwiseAbs().maxCoeff();
    const std::vector<int> met = {3, 2, 4}, apart = {n - 1, 0, n / 2};
    EXPECT_TRUE(sparse.has(met));
    EXPECT_FALSE(sparse.has(apart));
    for (const auto& unknowns : {met, apart})
      EXPECT_LT((sparse.joint(unknowns) - whole.joint(unknowns)).cwiseAbs().maxCoeff(), 1e-11 * size);
    EXPECT_NEAR(sparse(n - 1, 1), q(n - 1, 1), 1e-11 * size);
    const Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(n, -1, 2);
    EXPECT_LT((sparse.times(x) - q * x).cwiseAbs().maxCoeff(), 1e-10 * (q * x).cwiseAbs().maxCoeff());
    std::vector<Functional> functionals;
    for (int k = 0; k < 130; ++k) functionals.push_back({{k % n, 1.0}, {(7 * k + 3) % n, -0.5}});
    const Eigen::VectorXd a = whole.variances(functionals), b = sparse.variances(functionals);
    EXPECT_LT((a - b).cwiseAbs().maxCoeff(), 1e-11 * size);
    Cofactors scaled = sparse;
    scaled.multiply(4);
    EXPECT_DOUBLE_EQ(scaled(2, 3), 4 * sparse(2, 3));
    EXPECT_THROW(scaled.whole(), std::logic_error);
    ReliabilityOptions with_groups;
    with_groups.groups.resize(n);
    for (int u = 0; u < n; ++u) with_groups.groups[u] = {u};
    const Reliability ra = compute_reliability(problem, s, whole, with_groups),
                      rb = compute_reliability(problem, s, sparse, with_groups);
    for (size_t r = 0; r < ra.rows.size(); ++r) {
      EXPECT_NEAR(ra.rows[r].redundancy_number, rb.rows[r].redundancy_number, 1e-9);
      EXPECT_NEAR(ra.rows[r].w, rb.rows[r].w, 1e-6 * (1 + std::abs(ra.rows[r].w)));
      if (!std::isfinite(ra.rows[r].mdb)) continue;
      EXPECT_LE(rb.rows[r].external_effect, ra.rows[r].external_effect * (1 + 1e-6)) << "of its own points only";
    }
    EXPECT_NEAR(ra.sum_of_redundancy_numbers, s.degrees_of_freedom(), 1e-7);
    EXPECT_NEAR(rb.sum_of_redundancy_numbers, s.degrees_of_freedom(), 1e-7);
  }
}

/// Measured values without those that held them: the same as a problem that never had these.
TEST(Factors, WhatTheRestSaysOfSomeIsThatOfAProblemOfItsOwn) {
  const std::vector<Component> corners = {{0, 0}, {0, 1}, {2, 0}, {2, 1}, {3, 0}, {3, 1}};
  Problem alone = trilateration();
  SolverOptions free;
  free.datum_unknowns = {0, 1, 4, 5, 6, 7};
  const Solution own = solve(alone, free);
  const Eigen::MatrixXd q = cofactor_matrix(own);
  for (const bool held : {true, false}) {
    SCOPED_TRACE(held ? "held" : "weighted");
    Problem problem = trilateration();
    std::vector<char> left_out(problem.residuals.size(), 0);
    for (const auto& [block, component] : corners) {
      problem.parameters[block].value[component] += 1e-4 * (block - 1) * (component + 1);
      if (held) {
        problem.parameters[block].constant = {true, true};
        continue;
      }
      Eigen::MatrixXd row = Eigen::MatrixXd::Zero(1, 2);
      row(0, component) = 1;
      auto known = std::make_unique<LinearResidual>(
          row, Eigen::VectorXd::Constant(1, problem.parameters[block].value[component]));
      known->set_sigmas(Eigen::VectorXd::Constant(1, 1e-4));
      known->parameters = {block};
      problem.residuals.push_back(std::move(known));
      left_out.push_back(1);
    }
    const Solution s = solve(problem, {});
    const std::vector<double> before = problem.parameters[2].value;
    const auto rest = marginal_of(problem, s, left_out, corners);
    ASSERT_TRUE(rest.has_value());
    EXPECT_EQ(problem.parameters[2].value, before) << "the problem is as it was";
    EXPECT_EQ(problem.parameters[2].constant.empty(), !held);
    EXPECT_EQ(rest->null_space.cols(), 3);
    EXPECT_EQ(rest->degrees_of_freedom, own.degrees_of_freedom());
    EXPECT_NEAR(rest->sum_of_squares, own.sum_of_squares(), 1e-9);
    // In any datum: lengths between the corners, and their variances.
    for (const auto& [i, j] : {std::pair{0, 1}, {0, 2}, {1, 2}}) {
      const auto& a = alone.parameters[corners[2 * i].block].value;
      const auto& b = alone.parameters[corners[2 * j].block].value;
      const Eigen::Vector2d d = Eigen::Vector2d(b.data()) - Eigen::Vector2d(a.data());
      EXPECT_NEAR((rest->values.segment<2>(2 * j) - rest->values.segment<2>(2 * i)).norm(), d.norm(), 1e-9);
      Eigen::VectorXd f = Eigen::VectorXd::Zero(8), g = Eigen::VectorXd::Zero(6);
      f.segment<2>(2 * corners[2 * j].block) = d.normalized(), f.segment<2>(2 * corners[2 * i].block) = -d.normalized();
      g.segment<2>(2 * j) = d.normalized(), g.segment<2>(2 * i) = -d.normalized();
      EXPECT_NEAR(g.dot(rest->cofactors * g) / f.dot(q * f), 1, 5e-3) << "linearised 0.8 m of 100 m away";
    }
  }
  Problem problem = trilateration();
  const Solution s = solve(problem, free);
  EXPECT_FALSE(marginal_of(problem, s, std::vector<char>(6, 0), corners).has_value()) << "nothing holds it";
}

/// A reading less: the order of elimination is that of before, and where it ends that of a start from the beginning.
TEST(Factors, ASolutionGoesOnFromTheOneBefore) {
  Problem all = trilateration();
  SolverOptions options;
  options.datum_unknowns = all_unknowns(8);
  const Solution before = solve(all, options);
  const auto less = [] {
    Problem problem = trilateration();
    problem.residuals.erase(problem.residuals.begin() + 4);
    return problem;
  };
  Problem afresh = less(), onwards = less();
  const Solution other = solve(afresh, options);
  for (size_t p = 0; p < 4; ++p) onwards.parameters[p].value = all.parameters[p].value;
  options.before = &before;
  const Solution s = solve(onwards, options);
  EXPECT_EQ(s.normal.analysis(), before.normal.analysis());
  EXPECT_TRUE(s.converged);
  EXPECT_LE(s.iterations(), other.iterations());
  for (size_t p = 0; p < 4; ++p)
    for (size_t c = 0; c < 2; ++c) EXPECT_NEAR(onwards.parameters[p].value[c], afresh.parameters[p].value[c], 1e-7);
  EXPECT_LT((cofactor_matrix(s) - cofactor_matrix(other)).cwiseAbs().maxCoeff(), 1e-9);
}

}  // namespace test_factors
}  // namespace plumbline::least_squares

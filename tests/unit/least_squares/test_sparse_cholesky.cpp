// The sparse factor and what is asked of its inverse, against Eigen's dense inverse of the same matrix.
#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "geometry/random.hpp"
#include "least_squares/sparse/conjugate_gradients.hpp"
#include "least_squares/sparse/selected_inverse.hpp"
#include "least_squares/sparse/sparse_cholesky.hpp"
#include "plumbline/stop.hpp"

namespace test_sparse_cholesky {

using namespace plumbline;
using namespace plumbline::least_squares;

/// Observations of a few blocks each: what couples them, and their part of the normal matrix.
struct Normal {
  Pattern pattern;
  SymmetricBlocks blocks;
  Eigen::MatrixXd dense;
};

Normal normal_of(const std::vector<int>& sizes, const std::vector<std::vector<int>>& observations, uint64_t seed,
                 double prior = 0.1) {
  Pattern pattern(sizes);
  for (const auto& touched : observations) pattern.couple(touched);
  Normal made{pattern, SymmetricBlocks(pattern), {}};
  made.dense = prior * Eigen::MatrixXd::Identity(pattern.unknown_count(), pattern.unknown_count());
  for (int b = 0; b < pattern.block_count(); ++b)
    made.blocks.add(b, b, prior * Eigen::MatrixXd::Identity(pattern.size(b), pattern.size(b)));
  Random random(seed);
  for (const auto& touched : observations) {
    std::vector<Eigen::MatrixXd> jacobian;
    for (int b : touched)
      jacobian.push_back(Eigen::MatrixXd::NullaryExpr(2, pattern.size(b), [&] { return random.normal(); }));
    for (size_t i = 0; i < touched.size(); ++i)
      for (size_t j = 0; j < touched.size(); ++j) {
        const Eigen::MatrixXd product = jacobian[i].transpose() * jacobian[j];
        made.dense.block(pattern.offset(touched[i]), pattern.offset(touched[j]), product.rows(), product.cols()) +=
            product;
        if (i >= j) made.blocks.add(touched[i], touched[j], product);
      }
  }
  return made;
}

std::vector<std::vector<int>> random_observations(int blocks, int count, uint64_t seed) {
  Random random(seed);
  std::vector<std::vector<int>> observations;
  for (int i = 0; i < count; ++i) {
    std::vector<int> touched;
    for (int k = 0; k < 2 + i % 3; ++k) {
      const int b = static_cast<int>(random.uniform() * blocks);
      if (std::find(touched.begin(), touched.end(), b) == touched.end()) touched.push_back(b);
    }
    observations.push_back(touched);
  }
  return observations;
}

/// Largest difference of cofactors, in units of the standard deviations they belong to.
double difference(const Eigen::MatrixXd& found, const Eigen::MatrixXd& expected, const Eigen::VectorXd& row_sigmas,
                  const Eigen::VectorXd& column_sigmas) {
  if (found.rows() != expected.rows() || found.cols() != expected.cols()) return std::nan("");
  if (found.size() == 0) return 0;
  return (row_sigmas.cwiseInverse().asDiagonal() * (found - expected) * column_sigmas.cwiseInverse().asDiagonal())
      .cwiseAbs()
      .maxCoeff();
}

/// Everything that is asked of a factor, against the dense inverse.
void expect_exact(const Normal& normal) {
  const Pattern& p = normal.pattern;
  const Eigen::Index n = p.unknown_count();
  const Eigen::MatrixXd inverse =
      n > 0 ? Eigen::MatrixXd(normal.dense.llt().solve(Eigen::MatrixXd::Identity(n, n))) : Eigen::MatrixXd(0, 0);
  const Eigen::VectorXd sigmas = inverse.diagonal().cwiseSqrt();
  const auto of_block = [&](int b) { return sigmas.segment(p.offset(b), p.size(b)); };
  const auto analysis = std::make_shared<const Analysis>(p);
  SparseCholesky factor(analysis);
  ASSERT_TRUE(factor.factorise(normal.blocks));
  EXPECT_EQ(analysis->bytes(), sizeof(double) * factor.values().size());
  Random random(77);
  const Eigen::MatrixXd right = Eigen::MatrixXd::NullaryExpr(n, 5, [&] { return random.normal(); });
  const Eigen::MatrixXd x = factor.solve(right), expected = inverse * right;
  EXPECT_LE((x - expected).norm(), 1e-12 * expected.norm());
  EXPECT_LE((normal.blocks.multiply(right) - normal.dense * right).norm(), 1e-13 * (normal.dense * right).norm());
  EXPECT_LE((factor.covariance(right) - right.transpose() * expected).norm(),
            1e-12 * (right.transpose() * expected).norm());
  std::vector<int> unknowns, blocks;
  for (int u = static_cast<int>(n) - 1; u >= 0; u -= 3) unknowns.push_back(u);
  for (int b = p.block_count() - 1; b >= 0; b -= 2) blocks.push_back(b);
  EXPECT_LT(difference(factor.columns(unknowns), inverse(Eigen::all, unknowns), sigmas, sigmas(unknowns)), 1e-12);
  std::vector<int> of_blocks;
  for (int b : blocks)
    for (int c = 0; c < p.size(b); ++c) of_blocks.push_back(p.offset(b) + c);
  EXPECT_LT(difference(factor.cofactors(blocks), inverse(of_blocks, of_blocks), sigmas(of_blocks), sigmas(of_blocks)),
            1e-12);
  const SelectedInverse selected(factor);
  EXPECT_LT(difference(selected.diagonal(), inverse.diagonal(), sigmas.cwiseAbs2(), Eigen::VectorXd::Ones(1)), 1e-12);
  for (int a = 0; a < p.block_count(); ++a) {
    for (int b : p.after(a)) EXPECT_TRUE(selected.has(a, b)) << a << " " << b;
    for (int b = 0; b < p.block_count(); ++b) {
      if (!selected.has(a, b)) {
        EXPECT_THROW(selected.block(a, b), std::out_of_range);
        continue;
      }
      EXPECT_LT(difference(selected.block(a, b), inverse.block(p.offset(a), p.offset(b), p.size(a), p.size(b)),
                           of_block(a), of_block(b)),
                1e-12)
          << a << " " << b;
    }
  }
}

TEST(SparseCholesky, IsExactOnRandomProblems) {
  for (uint64_t seed = 1; seed <= 30; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    std::vector<int> sizes;
    const int blocks = 1 + static_cast<int>(seed * 7 % 60);
    for (int b = 0; b < blocks; ++b) sizes.push_back(static_cast<int>(random.uniform() * 8));  // 0 to 7
    expect_exact(normal_of(sizes, random_observations(blocks, blocks * (1 + static_cast<int>(seed % 3)), seed), seed));
  }
}

TEST(SparseCholesky, IsExactWhereNothingOrOneUnknownIsAsked) {
  expect_exact(normal_of({}, {}, 1));
  expect_exact(normal_of({0, 0}, {{0, 1}}, 1));
  expect_exact(normal_of({1}, {}, 1));
  expect_exact(normal_of({1}, {{0}}, 1));
  expect_exact(normal_of({0, 1, 0}, {{0, 1, 2}}, 1));
}

TEST(SparseCholesky, IsExactOnPartsThatDoNotMeet) {
  std::vector<std::vector<int>> observations;
  for (int b = 0; b < 40; ++b)
    if (b % 10 != 9) observations.push_back({b, b + 1});
  expect_exact(normal_of(std::vector<int>(41, 3), observations, 3));
}

TEST(SparseCholesky, IsExactWithOneBlockThatMeetsAll) {
  std::vector<std::vector<int>> observations;
  for (int b = 1; b < 80; ++b) observations.push_back({0, b});
  std::vector<int> sizes(80, 2);
  sizes[0] = 11;
  expect_exact(normal_of(sizes, observations, 4));
}

// Wide supernodes, wider than a panel and with rows below, and a full matrix.
TEST(SparseCholesky, IsExactOnAGridAndOnAFullMatrix) {
  std::vector<std::vector<int>> grid, full;
  constexpr int side = 14;
  for (int i = 0; i < side; ++i)
    for (int j = 0; j < side; ++j) {
      if (i > 0) grid.push_back({side * (i - 1) + j, side * i + j});
      if (j > 0) grid.push_back({side * i + j - 1, side * i + j});
    }
  expect_exact(normal_of(std::vector<int>(side * side, 6), grid, 5));
  for (int i = 0; i < 30; ++i)
    for (int j = 0; j < i; ++j) full.push_back({j, i});
  expect_exact(normal_of(std::vector<int>(30, 5), full, 6));
}

// Jacobi scaling and a prior, without a second matrix.
TEST(SparseCholesky, FactorisesAScaledMatrix) {
  for (int blocks : {10, 60}) {
    const Normal normal = normal_of(std::vector<int>(blocks, 4), random_observations(blocks, 2 * blocks, 8), 8);
    const Eigen::Index n = 4 * blocks;
    SparseCholesky factor(std::make_shared<const Analysis>(normal.pattern));
    const Scaling scaling{normal.blocks.diagonal().cwiseSqrt().cwiseInverse(), Eigen::VectorXd::Constant(n, 0.25)};
    ASSERT_TRUE(factor.factorise(normal.blocks, 0, scaling));
    Eigen::MatrixXd scaled = scaling.scale.asDiagonal() * normal.dense * scaling.scale.asDiagonal();
    scaled.diagonal().array() += 0.25;
    const Eigen::MatrixXd inverse = scaled.llt().solve(Eigen::MatrixXd::Identity(n, n));
    const Eigen::VectorXd right = Eigen::VectorXd::LinSpaced(n, -1, 2);
    EXPECT_LT((factor.solve(right) - inverse * right).norm(), 1e-12 * (inverse * right).norm());
    SelectedInverse selected(factor);
    EXPECT_EQ(factor.analysis().is_dense(), blocks == 10);
    if (factor.analysis().is_dense()) {
      EXPECT_LT((selected.dense() - inverse).cwiseAbs().maxCoeff(), 1e-12);
    }
    selected.scale(scaling.scale);
    const Eigen::VectorXd unscaled = scaling.scale.cwiseAbs2().cwiseProduct(inverse.diagonal());
    EXPECT_LT((selected.diagonal() - unscaled).norm(), 1e-12 * unscaled.norm());
    const std::vector<int> some = {7, 3};
    if (selected.has(7, 3)) {
      const Eigen::MatrixXd joint = selected.joint(some);
      EXPECT_EQ(joint.topRightCorner(4, 4), selected.block(7, 3));
      EXPECT_EQ(joint.bottomRightCorner(4, 4), selected.block(3, 3));
    }
  }
}

TEST(ConjugateGradients, ComeToTheSolutionAndAreADescentBefore) {
  std::vector<std::vector<int>> observations;
  for (int k = 0; k < 40; ++k)
    for (int far : {1, 2, 7}) observations.push_back({k, (k + far) % 40});
  const Normal normal = normal_of(std::vector<int>(40, 3), observations, 4);
  ConjugateGradients gradients;
  ASSERT_TRUE(gradients.prepare(normal.blocks));
  Random random(9);
  const Eigen::VectorXd right = Eigen::VectorXd::NullaryExpr(120, [&] { return random.normal(); });
  const auto exact = gradients.solve(right, {1e-12, 1000}), early = gradients.solve(right, {1e-12, 5});
  EXPECT_TRUE(exact.reached);
  EXPECT_LT((exact.x - normal.dense.llt().solve(right)).norm(), 1e-9 * exact.x.norm());
  EXPECT_FALSE(early.reached);
  EXPECT_EQ(early.steps, 5);
  // What it is short of is at right angles to where it is: the cost falls by x' b, as is predicted of exact steps.
  EXPECT_NEAR(early.x.dot(right - normal.dense * early.x) / early.x.dot(right), 0, 1e-9);
  EXPECT_EQ(gradients.solve(Eigen::VectorXd::Zero(120)).x.norm(), 0);
  SymmetricBlocks open(normal.pattern);
  for (int b = 0; b < 40; ++b) open.add(b, b, Eigen::Matrix3d(Eigen::Vector3d(1, 1, b == 7 ? 0 : 1).asDiagonal()));
  EXPECT_FALSE(gradients.prepare(open));
  EXPECT_EQ(gradients.undetermined(), 7);
}

TEST(SparseCholesky, GivesTheSameBitsAgain) {
  const auto observations = random_observations(50, 60, 9);
  const Normal normal = normal_of(std::vector<int>(50, 4), observations, 9);
  Pattern mirrored(std::vector<int>(50, 4));  // the same pairs, told the other way round
  for (auto touched = observations.rbegin(); touched != observations.rend(); ++touched)
    mirrored.couple(std::vector<int>(touched->rbegin(), touched->rend()));
  SparseCholesky a(std::make_shared<const Analysis>(normal.pattern)), b(std::make_shared<const Analysis>(mirrored));
  a.factorise(normal.blocks), b.factorise(normal.blocks);
  EXPECT_EQ(a.values(), b.values());
  b.factorise(normal.blocks);  // in the same memory once more
  EXPECT_EQ(a.values(), b.values());
  EXPECT_EQ(SelectedInverse(a).diagonal(), SelectedInverse(std::move(b)).diagonal());
}

// A long chain with shared unknowns costs what its length is; no order of a grid's rows is as good as a dissection.
TEST(Analysis, KeepsFillSmall) {
  constexpr int length = 2000;
  Pattern chain(std::vector<int>(length, 6));
  for (int b = 1; b < length; ++b) chain.couple(b - 1, b), chain.couple(0, b);
  const Analysis analysis(chain);
  EXPECT_LT(analysis.bytes(), 8u * length * 6 * 40);
  constexpr int side = 60;
  Pattern grid(std::vector<int>(side * side, 1));
  for (int i = 0; i < side; ++i)
    for (int j = 0; j < side; ++j) {
      if (i > 0) grid.couple(side * (i - 1) + j, side * i + j);
      if (j > 0) grid.couple(side * i + j - 1, side * i + j);
    }
  EXPECT_LT(Analysis(grid).operations(), 0.35 * side * side * side * side);  // a band: side^4
}

std::vector<std::string> names(const SparseCholesky& factor) {
  std::vector<std::string> result;
  for (const auto& u : factor.undetermined())
    result.push_back(std::to_string(u.block) + "." + std::to_string(u.component));
  return result;
}

// Heights from differences alone: each part of the network floats.
TEST(SparseCholesky, NamesAnUnknownForEachDefect) {
  Pattern pattern(std::vector<int>(9, 1));
  std::vector<std::pair<int, int>> lines = {{0, 1}, {1, 2}, {0, 2}, {2, 3}, {4, 5}, {5, 6}, {4, 6}};
  for (auto [a, b] : lines) pattern.couple(a, b);
  SymmetricBlocks normal(pattern);
  const Eigen::MatrixXd one = Eigen::MatrixXd::Ones(1, 1);
  for (auto [a, b] : lines) normal.add(a, a, one), normal.add(b, b, one), normal.add(a, b, -one);
  normal.add(8, 8, one);  // 7 is seen by nobody
  SparseCholesky factor(std::make_shared<const Analysis>(pattern));
  EXPECT_FALSE(factor.factorise(normal));
  ASSERT_EQ(factor.undetermined().size(), 3u);
  int of_first = 0, of_second = 0, of_none = 0;
  for (const auto& u : factor.undetermined()) {
    of_first += u.block <= 3, of_second += u.block >= 4 && u.block <= 6, of_none += u.block == 7;
    EXPECT_EQ(u.component, 0);
    EXPECT_LT(std::abs(u.pivot), 1e-12);
  }
  EXPECT_TRUE(of_first == 1 && of_second == 1 && of_none == 1) << testing::PrintToString(names(factor));
  // With those held the rest is as usual: a step of one from 0 to 3.
  Eigen::VectorXd right = Eigen::VectorXd::Zero(9);
  right(0) = -1, right(3) = 1;
  const Eigen::VectorXd x = factor.solve(right);
  EXPECT_LT((normal.multiply(x) - right).norm(), 1e-12);
  for (const auto& u : factor.undetermined()) EXPECT_EQ(x(u.block), 0);
  const SelectedInverse inverse(factor);
  for (const auto& u : factor.undetermined()) EXPECT_EQ(inverse.block(u.block, u.block)(0, 0), 0);
}

TEST(SparseCholesky, NamesTheBlockAndItsComponent) {
  Pattern pattern({3, 6, 2});
  pattern.couple(0, 1), pattern.couple(1, 2);
  SymmetricBlocks normal(pattern);
  for (int b = 0; b < 3; ++b) normal.at(b, b).setIdentity();
  normal.at(1, 1)(4, 4) = 0;
  SparseCholesky factor(std::make_shared<const Analysis>(pattern));
  EXPECT_FALSE(factor.factorise(normal));
  EXPECT_EQ(names(factor), std::vector<std::string>{"1.4"});
  normal.at(1, 1)(4, 4) = std::nan("");
  EXPECT_FALSE(factor.factorise(normal));
  EXPECT_EQ(names(factor), std::vector<std::string>{"1.4"});
  // The tolerance is relative to the diagonal: units do not count.
  for (double unit : {1e-12, 1.0, 1e12}) {
    normal.at(1, 1).diagonal().setConstant(unit);
    EXPECT_TRUE(factor.factorise(normal)) << unit;
    normal.at(1, 1)(5, 4) = unit * (1 - 1e-14);
    EXPECT_FALSE(factor.factorise(normal)) << unit;
    normal.at(1, 1)(5, 4) = 0;
  }
}

TEST(SparseCholesky, RefusesWhatIsNotOnThePattern) {
  Pattern pattern({2, 2, 2});
  pattern.couple(0, 1);
  EXPECT_THROW(pattern.couple(0, 3), std::out_of_range);
  EXPECT_THROW(Pattern({-1}), std::out_of_range);
  SymmetricBlocks normal(pattern);
  EXPECT_THROW(normal.at(2, 0), std::out_of_range);
  EXPECT_THROW(normal.at(0, 1), std::out_of_range);
  Pattern other({2, 2});
  SparseCholesky factor(std::make_shared<const Analysis>(other));
  EXPECT_THROW(factor.factorise(normal), std::logic_error);
  Pattern apart(std::vector<int>(40, 3)), chain = apart;
  for (int b = 1; b < 40; ++b) chain.couple(b - 1, b);
  SparseCholesky of_apart(std::make_shared<const Analysis>(apart));
  EXPECT_THROW(of_apart.factorise(SymmetricBlocks(chain)), std::logic_error);
}

TEST(SparseCholesky, CanBeStopped) {
  const Normal normal = normal_of(std::vector<int>(20, 3), random_observations(20, 40, 2), 2);
  const auto analysis = std::make_shared<const Analysis>(normal.pattern);
  SparseCholesky factor(analysis);
  ASSERT_TRUE(factor.factorise(normal.blocks));
  const StopScope scope([](const void*) { return true; }, nullptr);
  EXPECT_THROW(Analysis{normal.pattern}, Stopped);
  EXPECT_THROW(factor.factorise(normal.blocks), Stopped);
  EXPECT_THROW(SelectedInverse{factor}, Stopped);
  EXPECT_THROW(factor.solve(Eigen::VectorXd::Ones(60)), Stopped);
}

}  // namespace test_sparse_cholesky

// Covariances in blocks are the matrices that they stand for, whatever is asked of them.
#include <gtest/gtest.h>

#include "building/judgement/block_covariance.hpp"
#include "building/judgement/difference.hpp"
#include "geometry/packed_symmetric.hpp"
#include "small_building.hpp"

namespace plumbline::judgement {
namespace test_block_covariance {

/// Six points of which 0, 2 and 5 know of one another (0 and 5 by way of 2), and 3 and 4.
Eigen::MatrixXd matrix(std::uint64_t seed) {
  test::Normal normal(seed);
  Eigen::MatrixXd s = Eigen::MatrixXd::Zero(18, 18);
  const auto tie = [&](std::vector<Eigen::Index> points) {
    Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(18, 4);
    for (const Eigen::Index p : points)
      for (Eigen::Index k = 0; k < 12; ++k) rows(3 * p + k % 3, k / 3) = normal();
    s += rows * rows.transpose();
  };
  for (Eigen::Index p = 0; p < 6; ++p) tie({p});
  tie({0, 2}), tie({2, 5}), tie({3, 4});
  return s;
}

TEST(BlockCovariance, IsTheMatrixItWasMadeOf) {
  const Eigen::MatrixXd full = matrix(1);
  const BlockCovariance blocks = full, packed = BlockCovariance::from_packed(pack_symmetric(full), 6, "x");
  ASSERT_EQ(blocks.clusters().size(), 3u);
  EXPECT_EQ(blocks.clusters()[0].items, (std::vector<Eigen::Index>{0, 2, 5}));
  EXPECT_EQ(blocks.dense(), full);
  EXPECT_EQ(packed.dense(), full);
  for (Eigen::Index i = 0; i < 18; ++i)
    for (Eigen::Index j = 0; j < 18; ++j) EXPECT_EQ(blocks(i, j), full(i, j));
  EXPECT_EQ(blocks.block(2, 5), (full.block<3, 3>(6, 15)));
  EXPECT_EQ(blocks.block(1, 5), Eigen::Matrix3d::Zero());
  EXPECT_EQ(blocks.diagonal(), full.diagonal());
  EXPECT_NEAR(blocks.sum(), full.sum(), 1e-12);
  EXPECT_NEAR(blocks.squaredNorm(), full.squaredNorm(), 1e-10);
  Eigen::SparseVector<double> weights(18);
  for (const Eigen::Index i : {0, 4, 7, 8, 9, 17}) weights.insert(i) = 1 + 0.1 * static_cast<double>(i);
  const Eigen::VectorXd w = weights;
  EXPECT_NEAR(blocks.quadratic(weights), w.dot(full * w), 1e-10);
  Eigen::MatrixXd heights(6, 6);
  for (Eigen::Index i = 0; i < 6; ++i)
    for (Eigen::Index j = 0; j < 6; ++j) heights(i, j) = full(3 * i + 2, 3 * j + 2);
  EXPECT_EQ(blocks.heights().dense(), heights);
  const std::vector<std::size_t> some = {5, 1, 0, 3};
  const BlockCovariance part = blocks.subset(some);
  EXPECT_EQ(part.dense(), blocks.dense(some));
  for (Eigen::Index i = 0; i < 4; ++i)
    for (Eigen::Index j = 0; j < 4; ++j)
      EXPECT_EQ(part.block(i, j), blocks.block(static_cast<Eigen::Index>(some[i]), static_cast<Eigen::Index>(some[j])));
  BlockCovariance given = blocks;
  EXPECT_EQ(std::move(given).subset(some).dense(), part.dense());
  BlockCovariance taken = blocks;
  EXPECT_EQ(std::move(taken).subset({0, 1, 2, 3, 4, 5}).dense(), full);
  BlockCovariance more = blocks;
  more *= 2;
  more.add(5, Eigen::Matrix3d::Identity());
  Eigen::MatrixXd expected = 2 * full;
  expected.diagonal().tail<3>().array() += 1;
  EXPECT_LT((more.dense() - expected).norm(), 1e-12);
}

/// Many that know of one another are read where the artifact has them, and are the same matrix.
TEST(BlockCovariance, ALargePartIsReadWhereItLies) {
  constexpr Eigen::Index points = 130, n = 3 * points;
  test::Normal normal(5);
  Eigen::MatrixXd rows(n, 5);
  for (Eigen::Index i = 0; i < rows.size(); ++i) rows.data()[i] = normal();
  const Eigen::MatrixXd full = rows * rows.transpose() + Eigen::MatrixXd::Identity(n, n);
  const std::vector<double> values = pack_symmetric(full);
  BlockCovariance packed = BlockCovariance::from_packed(values, points, "x");
  ASSERT_EQ(packed.clusters().size(), 1u);
  EXPECT_FALSE(packed.clusters()[0].matrix.is_full());
  EXPECT_EQ(packed.dense(), full);
  EXPECT_EQ(packed.block(7, 120), (full.block<3, 3>(21, 360)));
  EXPECT_EQ(packed.diagonal(), full.diagonal());
  EXPECT_NEAR(packed.sum(), full.sum(), 1e-9);
  EXPECT_NEAR(packed.squaredNorm(), full.squaredNorm(), 1e-7);
  EXPECT_TRUE(packed.allFinite());
  const SymmetricMatrix& matrix = packed.clusters()[0].matrix;
  EXPECT_NEAR(matrix.row_sum_norm(), full.cwiseAbs().rowwise().sum().maxCoeff(), 1e-9);
  const Eigen::MatrixXd right = rows.leftCols(2);
  EXPECT_TRUE(matrix.times(right).isApprox(full * right, 1e-12));
  packed *= 2;
  packed.add(5, 3 * Eigen::Matrix3d::Identity());
  Eigen::MatrixXd expected = 2 * full;
  expected.diagonal().segment<3>(15).array() += 3;
  std::vector<std::size_t> back;
  for (std::size_t p = points; p > 0; --p) back.push_back(p - 1);
  const BlockCovariance turned = std::move(packed).subset(back);
  for (Eigen::Index i = 0; i < n; i += 7)
    for (Eigen::Index j = 0; j < n; j += 5)
      EXPECT_NEAR(turned(i, j), expected(3 * (points - 1 - i / 3) + i % 3, 3 * (points - 1 - j / 3) + j % 3), 1e-12);
  EXPECT_NEAR(turned.heights()(1, 2), expected(3 * (points - 2) + 2, 3 * (points - 3) + 2), 1e-12);
}

/// What all have in common is as if it stood in every block.
TEST(BlockCovariance, ACommonErrorIsThatOfAllPairs) {
  const Eigen::MatrixXd own = matrix(3);
  Eigen::Matrix3d common = Eigen::Matrix3d::Identity() * 2;
  common(0, 1) = common(1, 0) = 0.5;
  const Eigen::MatrixXd full = own + common.replicate(6, 6);
  BlockCovariance blocks = own;
  blocks.set_common(common);
  EXPECT_TRUE(blocks.dense().isApprox(full, 1e-13));
  EXPECT_TRUE(blocks.block(1, 5).isApprox(full.block<3, 3>(3, 15)) &&
              blocks.block(2, 2).isApprox(full.block<3, 3>(6, 6)));
  EXPECT_NEAR(blocks(4, 12), full(4, 12), 1e-12);
  EXPECT_TRUE(blocks.diagonal().isApprox(full.diagonal(), 1e-13));
  EXPECT_NEAR(blocks.sum(), full.sum(), 1e-9);
  EXPECT_NEAR(blocks.squaredNorm(), full.squaredNorm(), 1e-9);
  Eigen::SparseVector<double> weights(18);
  for (Eigen::Index k : {0, 4, 8, 17}) weights.insert(k) = 1.0 + static_cast<double>(k);
  const Eigen::VectorXd w = weights;
  EXPECT_NEAR(blocks.quadratic(weights), w.dot(full * w), 1e-9);
  const BlockCovariance some = std::as_const(blocks).subset({5, 0, 3});
  EXPECT_NEAR(some(0, 3), full(15, 0), 1e-12);
  EXPECT_NEAR(some(8, 8), full(11, 11), 1e-12);
  EXPECT_NEAR(blocks.heights()(1, 4), full(5, 14), 1e-12);
  EXPECT_NEAR((blocks *= 4)(0, 0), 4 * full(0, 0), 1e-12);
}

TEST(BlockCovariance, UnknownAndWrongOnesSaySo) {
  EXPECT_EQ(BlockCovariance().size(), 0);
  EXPECT_EQ(BlockCovariance(Eigen::MatrixXd()).size(), 0);
  EXPECT_THROW(BlockCovariance(Eigen::MatrixXd::Zero(4, 4)), std::runtime_error);
  EXPECT_THROW(BlockCovariance::from_packed(std::vector<double>(5), 1, "input 'model'"), std::runtime_error);
}

/// The difference of two sets in blocks is that of the same sets in one piece.
TEST(BlockCovariance, DifferencesComeOutAsInOnePiece) {
  Eigen::MatrixXd survey = matrix(2);
  // As an adjustment to the control of points 0 to 3 leaves it: less than the survey by what photographs add.
  Eigen::MatrixXd model = (survey.inverse() + 0.3 * Eigen::MatrixXd::Identity(18, 18)).inverse();
  for (Eigen::Index i = 0; i < 18; ++i)
    for (Eigen::Index j = 0; j < 18; ++j)
      if (survey(i, j) == 0) model(i, j) = 0;
  std::vector<Match> matches, control;
  for (std::size_t i = 0; i < 6; ++i) matches.push_back({i, i, i});
  for (std::size_t i = 0; i < 4; ++i) control.push_back(matches[i]);
  PointSet m, s, whole_m, whole_s;
  m.covariance = model, s.covariance = survey;
  // A trace of correlation between all keeps them in one piece.
  whole_m.covariance = model + Eigen::MatrixXd::Constant(18, 18, 1e-13);
  whole_s.covariance = survey + Eigen::MatrixXd::Constant(18, 18, 1e-13);
  ASSERT_EQ(whole_m.covariance.clusters().size(), 1u);
  const DifferenceCovariance parts = difference_covariance(m, s, matches, control),
                             whole = difference_covariance(whole_m, whole_s, matches, control);
  EXPECT_EQ(parts.consistent, whole.consistent);
  EXPECT_LT((parts.matrix.dense() - whole.matrix.dense()).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_GT(parts.matrix.clusters().size(), 1u);
}

}  // namespace test_block_covariance
}  // namespace plumbline::judgement

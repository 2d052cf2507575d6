// Elimination of one class of unknowns against the dense normal equations of all.
#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "geometry/packed_symmetric.hpp"
#include "geometry/random.hpp"
#include "least_squares/problem/schur.hpp"

namespace plumbline::least_squares {
namespace {

constexpr int kKept = 7, kBlocks = 4, kSize = 3;

Eigen::MatrixXd random_matrix(Random& random, int rows, int columns) {
  Eigen::MatrixXd m(rows, columns);
  for (int r = 0; r < rows; ++r)
    for (int c = 0; c < columns; ++c) m(r, c) = random.normal();
  return m;
}

/// Every block is seen six times, each time with two rows and two kept unknowns; two rows see kept unknowns only.
PartitionedSystem make_system() {
  Random random(7);
  PartitionedSystem system;
  system.kept_count = kKept;
  system.eliminated_count = kBlocks;
  system.eliminated_size = kSize;
  system.groups = {"blocks", "kept"};
  for (int k = 0; k < 6 * kBlocks; ++k) {
    ObservationRows rows;
    rows.eliminated = k % kBlocks;
    rows.columns = {(k + 3) % kKept, k % kKept};  // not ascending
    rows.kept = random_matrix(random, 2, 2);
    rows.own = random_matrix(random, 2, kSize);
    rows.misclosure = random_matrix(random, 2, 1);
    system.observations.push_back(rows);
  }
  ObservationRows rows;
  rows.group = 1;
  rows.columns = {1, 5, 2};
  rows.kept = random_matrix(random, 2, 3);
  rows.misclosure = random_matrix(random, 2, 1);
  system.observations.push_back(rows);
  return system;
}

struct Dense {
  Eigen::MatrixXd design, inverse;
  Eigen::VectorXd misclosure, solution;
};

Dense solve_dense(const PartitionedSystem& system) {
  Dense dense;
  dense.design = Eigen::MatrixXd::Zero(system.row_count(), system.unknown_count());
  dense.misclosure.resize(system.row_count());
  Eigen::Index row = 0;
  for (const auto& rows : system.observations) {
    const Eigen::Index count = rows.misclosure.size();
    for (size_t c = 0; c < rows.columns.size(); ++c)
      dense.design.block(row, rows.columns[c], count, 1) = rows.kept.col(static_cast<Eigen::Index>(c));
    if (rows.eliminated >= 0) dense.design.block(row, kKept + kSize * rows.eliminated, count, kSize) = rows.own;
    dense.misclosure.segment(row, count) = rows.misclosure;
    row += count;
  }
  dense.inverse = (dense.design.transpose() * dense.design).inverse();
  dense.solution = dense.inverse * dense.design.transpose() * dense.misclosure;
  return dense;
}

TEST(Schur, AgreesWithTheDenseNormalEquations) {
  const PartitionedSystem system = make_system();
  const Dense dense = solve_dense(system);
  const ReducedSystem reduced = reduce(system);
  PartitionedSolution solution;
  ASSERT_TRUE(solve_corrections(system, reduced, solution));
  add_cofactors(system, reduced, solution);
  EXPECT_LT((solution.kept - dense.solution.head(kKept)).norm(), 1e-12);
  EXPECT_LT((solution.kept_cofactor - dense.inverse.topLeftCorner(kKept, kKept)).norm(), 1e-12);
  for (int i = 0; i < kBlocks; ++i) {
    const int first = kKept + kSize * i;
    const auto at = static_cast<size_t>(i);
    EXPECT_LT((solution.eliminated[at] - dense.solution.segment(first, kSize)).norm(), 1e-12);
    EXPECT_LT((solution.eliminated_cofactor[at] - dense.inverse.block(first, first, kSize, kSize)).norm(), 1e-12);
    EXPECT_LT(
        (cross_cofactor(reduced.eliminated[at], solution.kept_cofactor) - dense.inverse.block(first, 0, kSize, kKept))
            .norm(),
        1e-12);
  }
}

TEST(Schur, ResidualCofactorsAndVarianceComponentsAddUpToTheRedundancy) {
  const PartitionedSystem system = make_system();
  const Dense dense = solve_dense(system);
  const ReducedSystem reduced = reduce(system);
  PartitionedSolution solution;
  ASSERT_TRUE(solve_corrections(system, reduced, solution));
  add_cofactors(system, reduced, solution);
  const auto cofactors = residual_cofactors(system, reduced, solution);
  const Eigen::MatrixXd expected = Eigen::MatrixXd::Identity(system.row_count(), system.row_count()) -
                                   dense.design * dense.inverse * dense.design.transpose();
  for (size_t i = 0; i < cofactors.size(); ++i) {
    const Eigen::Index row = 2 * static_cast<Eigen::Index>(i);
    EXPECT_LT((cofactors[i] - expected.block<2, 2>(row, row)).norm(), 1e-12) << i;
  }
  const auto components = variance_components(system, cofactors);
  ASSERT_EQ(components.size(), 2u);
  EXPECT_EQ(components[0].name, "blocks");
  EXPECT_EQ(components[1].rows, 2);
  EXPECT_NEAR(components[0].redundancy + components[1].redundancy, system.redundancy(), 1e-10);
  EXPECT_NEAR(components[0].factor, components[0].sum_of_squares / components[0].redundancy, 1e-12);
  // Σ v² and Σ r of each group, element by element.
  double squares[2] = {0, 0}, redundancy[2] = {0, 0};
  for (size_t i = 0; i < system.observations.size(); ++i)
    for (Eigen::Index k = 0; k < 2; ++k) {
      const auto g = static_cast<size_t>(system.observations[i].group);
      squares[g] += system.observations[i].misclosure(k) * system.observations[i].misclosure(k);
      redundancy[g] += expected(2 * static_cast<Eigen::Index>(i) + k, 2 * static_cast<Eigen::Index>(i) + k);
    }
  for (size_t g = 0; g < 2; ++g) {
    EXPECT_NEAR(components[g].sum_of_squares / squares[g], 1, 1e-12) << g;
    EXPECT_NEAR(components[g].redundancy, redundancy[g], 1e-10) << g;
    EXPECT_NEAR(components[g].factor / (squares[g] / redundancy[g]), 1, 1e-10) << g;
  }
}

/// Heights of which only differences are observed: the datum is the mean of two of them.
TEST(Schur, InnerConstraintsGiveTheCofactorsOfTheDatum) {
  PartitionedSystem system;
  system.kept_count = 4;
  system.groups = {"differences"};
  const int pairs[][2] = {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {0, 2}};
  for (const auto& [from, to] : pairs) {
    ObservationRows rows;
    rows.columns = {from, to};
    rows.kept = Eigen::RowVector2d(-1, 1);
    rows.misclosure = Eigen::VectorXd::Constant(1, 0.1 * to);
    system.observations.push_back(rows);
  }
  system.null_space = Eigen::VectorXd::Ones(4);
  system.datum_unknowns = {1, 3};
  const ReducedSystem reduced = reduce(system);
  PartitionedSolution solution;
  ASSERT_TRUE(solve_corrections(system, reduced, solution));
  add_cofactors(system, reduced, solution);
  EXPECT_EQ(system.redundancy(), 2);
  const Eigen::MatrixXd& q = solution.kept_cofactor;
  EXPECT_NEAR(q(1, 1) + 2 * q(1, 3) + q(3, 3), 0, 1e-12);  // the mean of the datum has no variance
  EXPECT_NEAR(solution.kept(1) + solution.kept(3), 0, 1e-12);
  // A difference has the same variance in every datum: here that of the network with point 0 held.
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(4, 4);
  for (const auto& [from, to] : pairs) {
    Eigen::Vector4d row = Eigen::Vector4d::Zero();
    row(from) = -1, row(to) = 1;
    normal += row * row.transpose();
  }
  const Eigen::MatrixXd held = normal.bottomRightCorner(3, 3).inverse();
  EXPECT_NEAR(q(0, 0) - 2 * q(0, 2) + q(2, 2), held(1, 1), 1e-12);
}

TEST(PackedSymmetric, ComesBack) {
  Eigen::Matrix3d m;
  m << 4, 1, 2, 1, 5, 3, 2, 3, 6;
  const std::vector<double> packed = pack_symmetric(m);
  EXPECT_EQ(packed, (std::vector<double>{4, 1, 5, 2, 3, 6}));
  EXPECT_EQ(unpack_symmetric(packed, 3, "a matrix"), m);
  EXPECT_EQ(unpack_symmetric({}, 3, "a matrix").size(), 0);
  EXPECT_THROW(unpack_symmetric(packed, 4, "a matrix"), std::runtime_error);
}

}  // namespace
}  // namespace plumbline::least_squares

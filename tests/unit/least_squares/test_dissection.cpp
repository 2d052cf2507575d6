// Orders by nested dissection: separators that separate, orders that leave nobody out, and less work where a block is
// wide.
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "geometry/random.hpp"
#include "least_squares/sparse/order.hpp"
#include "least_squares/sparse/selected_inverse.hpp"
#include "least_squares/sparse/separator.hpp"

namespace test_dissection {

using namespace plumbline;
using namespace plumbline::least_squares;

/// Images around a tower: each meets those at most two columns and two floors away.
Pattern tower(int around, int floors) {
  Pattern pattern(std::vector<int>(static_cast<size_t>(around * floors), 6));
  for (int i = 0; i < around; ++i)
    for (int j = 0; j < floors; ++j)
      for (int across = -2; across <= 2; ++across)
        for (int up = 0; up <= 2 && j + up < floors; ++up)
          pattern.couple(i * floors + j, (i + across + around) % around * floors + j + up);
  return pattern;
}

Graph graph_of(const Pattern& pattern) {
  Graph graph;
  for (const auto& list : neighbours_of(pattern)) {
    graph.neighbours.insert(graph.neighbours.end(), list.begin(), list.end());
    graph.starts.push_back(static_cast<int>(graph.neighbours.size()));
    graph.weights.push_back(1);
  }
  graph.edge_weights.assign(graph.neighbours.size(), 1);
  return graph;
}

/// Vertices on each side; fails if the sides meet.
std::vector<int> counted(const Graph& graph) {
  const std::vector<Side> sides = find_separator(graph);
  EXPECT_EQ(sides.size(), graph.weights.size());
  std::vector<int> count(3, 0);
  for (int v = 0; v < graph.size(); ++v) {
    ++count[sides[v]];
    for (int e = graph.starts[v]; e < graph.starts[v + 1]; ++e)
      EXPECT_NE(sides[v] + sides[graph.neighbours[e]], left + right) << v << " and " << graph.neighbours[e];
  }
  return count;
}

Pattern grid(int long_side, int short_side) {
  Pattern pattern(std::vector<int>(static_cast<size_t>(long_side * short_side), 1));
  for (int i = 0; i < long_side; ++i)
    for (int j = 0; j < short_side; ++j) {
      if (i > 0) pattern.couple(short_side * (i - 1) + j, short_side * i + j);
      if (j > 0) pattern.couple(short_side * i + j - 1, short_side * i + j);
    }
  return pattern;
}

TEST(Separator, CutsAGridAcross) {
  const std::vector<int> count = counted(graph_of(grid(60, 20)));
  EXPECT_LE(count[between], 22) << "20 do";
  EXPECT_GE(std::min(count[left], count[right]), 400);
}

TEST(Separator, OfPartsThatDoNotMeetIsEmpty) {
  Pattern parts(std::vector<int>(300, 1));
  for (int b = 0; b + 1 < 300; ++b)
    if (b % 100 != 99) parts.couple(b, b + 1);
  const std::vector<int> count = counted(graph_of(parts));
  EXPECT_LE(count[between], 1);
  EXPECT_GE(std::min(count[left], count[right]), 100);
  EXPECT_EQ(counted(graph_of(Pattern(std::vector<int>(500, 1))))[between], 0);
}

TEST(Separator, OfWhatAllMeetLeavesASideEmpty) {
  Pattern complete(std::vector<int>(150, 1));
  std::vector<int> all(150);
  std::iota(all.begin(), all.end(), 0);
  complete.couple(all);
  const std::vector<int> count = counted(graph_of(complete));
  EXPECT_EQ(std::min(count[left], count[right]), 0);
}

TEST(Dissection, LeavesNobodyOutAndTakesTheCameraLast) {
  Random random(5);
  for (const int count : {0, 1, 7, 400, 1500}) {
    std::vector<int> sizes(static_cast<size_t>(count), 6);
    if (count > 5) sizes[3] = 0;
    Pattern pattern(sizes);
    for (int k = 0; k < 4 * count; ++k) {
      const int from = static_cast<int>(random.uniform() * count), far = static_cast<int>(random.uniform() * 30);
      pattern.couple(from, (from + far) % count);
    }
    for (int b = 1; b < count; ++b) pattern.couple(0, b);
    const std::vector<int> order = nested_dissection_order(neighbours_of(pattern), sizes);
    std::vector<int> expected;
    for (int b = 0; b < count; ++b)
      if (sizes[b] > 0) expected.push_back(b);
    EXPECT_TRUE(std::is_permutation(order.begin(), order.end(), expected.begin(), expected.end())) << count;
    if (count >= 400) {
      EXPECT_EQ(order.back(), 0);
    }
    EXPECT_EQ(order, nested_dissection_order(neighbours_of(pattern), sizes)) << "not the same again";
  }
}

/// Multiplications of blocks of six in an order, without what supernodes add.
double operations_of(const Pattern& pattern, const std::vector<int>& order) {
  const auto neighbours = neighbours_of(pattern);
  std::vector<int> place(order.size());
  for (size_t k = 0; k < order.size(); ++k) place[order[k]] = static_cast<int>(k);
  std::vector<std::vector<int>> below(order.size());
  double operations = 0;
  for (size_t k = 0; k < order.size(); ++k) {
    for (int b : neighbours[order[k]])
      if (place[b] > static_cast<int>(k)) below[k].push_back(place[b]);
    std::sort(below[k].begin(), below[k].end());
    below[k].erase(std::unique(below[k].begin(), below[k].end()), below[k].end());
    const double rows = 6 * static_cast<double>(below[k].size());
    operations += 3 * rows * rows;
    if (below[k].empty()) continue;
    auto& parent = below[below[k].front()];
    parent.insert(parent.end(), below[k].begin() + 1, below[k].end());
  }
  return operations;
}

TEST(Dissection, IsLessWorkOnAWideBlockAndIsTaken) {
  const Pattern pattern = tower(90, 30);
  const auto neighbours = neighbours_of(pattern);
  const double by_degree = operations_of(pattern, minimum_degree_order(neighbours)),
               by_dissection = operations_of(pattern, nested_dissection_order(neighbours, std::vector<int>(2700, 6)));
  EXPECT_LT(by_dissection, 0.85 * by_degree);
  EXPECT_LT(Analysis(pattern).operations(), 1.1 * by_dissection);
}

/// What is factorised in that order is solved and inverted as in any other.
TEST(Dissection, ItsFactorIsExact) {
  const Pattern pattern = tower(60, 16);
  const auto analysis = std::make_shared<const Analysis>(pattern);
  ASSERT_FALSE(analysis->is_dense());
  // Supernodes only add to what an order multiplies: with minimum degree it would be no less than this.
  const double by_degree = operations_of(pattern, minimum_degree_order(neighbours_of(pattern)));
  ASSERT_LT(analysis->operations(), by_degree) << "dissection was not tried, or not taken";
  SymmetricBlocks normal(pattern);
  Random random(3);
  for (int b = 0; b < pattern.block_count(); ++b) {
    normal.add(b, b, 60 * Eigen::MatrixXd::Identity(6, 6));
    for (int other : pattern.after(b))
      normal.add(other, b, Eigen::MatrixXd::NullaryExpr(6, 6, [&] { return random.uniform() - 0.5; }));
  }
  SparseCholesky factor(analysis);
  ASSERT_TRUE(factor.factorise(normal));
  const Eigen::MatrixXd right =
      Eigen::MatrixXd::NullaryExpr(pattern.unknown_count(), 1, [&] { return random.normal(); });
  EXPECT_LT((normal.multiply(factor.solve(right)) - right).norm(), 1e-12 * right.norm());
  const std::vector<int> unknowns = {0, 777, pattern.unknown_count() - 1};
  const Eigen::MatrixXd columns = factor.columns(unknowns);
  const Eigen::VectorXd diagonal = SelectedInverse(std::move(factor)).diagonal();
  for (size_t k = 0; k < unknowns.size(); ++k)
    EXPECT_NEAR(diagonal[unknowns[k]] / columns(unknowns[k], static_cast<Eigen::Index>(k)), 1, 1e-12);
}

}  // namespace test_dissection

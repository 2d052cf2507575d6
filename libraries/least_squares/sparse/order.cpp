#include "least_squares/sparse/order.hpp"

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>
#include <algorithm>

namespace plumbline::least_squares {

std::vector<std::vector<int>> neighbours_of(const Pattern& pattern) {
  std::vector<std::vector<int>> result(static_cast<std::size_t>(pattern.block_count()));
  for (int b = 0; b < pattern.block_count(); ++b)
    for (int other : pattern.after(b)) {
      if (pattern.size(b) == 0 || pattern.size(other) == 0) continue;
      result[b].push_back(other);
      result[other].push_back(b);
    }
  for (auto& list : result) std::sort(list.begin(), list.end());
  return result;
}

std::vector<int> minimum_degree_order(const std::vector<std::vector<int>>& neighbours) {
  const auto n = static_cast<Eigen::Index>(neighbours.size());
  Eigen::SparseMatrix<char> graph(n, n);
  std::size_t count = neighbours.size();
  for (const auto& list : neighbours) count += list.size();
  graph.reserve(static_cast<Eigen::Index>(count));
  for (Eigen::Index b = 0; b < n; ++b) {
    graph.startVec(b);
    bool own = false;
    for (int other : neighbours[b]) {
      if (!own && other > b) graph.insertBack(b, b) = 1, own = true;
      graph.insertBack(other, b) = 1;
    }
    if (!own) graph.insertBack(b, b) = 1;
  }
  graph.finalize();
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> permutation;
  if (n > 0) Eigen::AMDOrdering<int>()(graph.selfadjointView<Eigen::Lower>(), permutation);
  return {permutation.indices().data(), permutation.indices().data() + n};
}

}  // namespace plumbline::least_squares

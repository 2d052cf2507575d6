// Orders of elimination of a block graph. Both are deterministic.
#pragma once

#include <vector>

#include "least_squares/sparse/pattern.hpp"

namespace plumbline::least_squares {

/// Neighbours of every block, both ways, ascending; blocks without unknowns have none.
std::vector<std::vector<int>> neighbours_of(const Pattern& pattern);

/// Approximate minimum degree (Eigen's); order[k] is the block that is eliminated as the k-th.
std::vector<int> minimum_degree_order(const std::vector<std::vector<int>>& neighbours);

}  // namespace plumbline::least_squares

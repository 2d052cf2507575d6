// Orders of elimination of a block graph. Both are deterministic; of large problems Analysis tries both and keeps the
// one that multiplies less.
#pragma once

#include <vector>

#include "least_squares/sparse/pattern.hpp"

namespace plumbline::least_squares {

/// Neighbours of every block, both ways, ascending; blocks without unknowns have none.
std::vector<std::vector<int>> neighbours_of(const Pattern& pattern);

/// Approximate minimum degree (Eigen's); order[k] is the block that is eliminated as the k-th.
std::vector<int> minimum_degree_order(const std::vector<std::vector<int>>& neighbours);

/// Nested dissection (George 1973): what separates two halves goes last, and so on in each of them; what is small, by
/// minimum degree. Blocks that meet very many others go behind all. `sizes` are their unknowns.
std::vector<int> nested_dissection_order(const std::vector<std::vector<int>>& neighbours,
                                         const std::vector<int>& sizes);

}  // namespace plumbline::least_squares

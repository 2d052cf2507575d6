// Few vertices of a graph whose removal leaves two parts of about the same weight that do not meet.
//
// Sources: Hendrickson & Rothberg (1998), Improving the run time and quality of nested dissection ordering; Karypis &
// Kumar (1998), A fast and high quality multilevel scheme for partitioning irregular graphs; Ashcraft & Liu (1997),
// Using domain decomposition to find graph bisectors. The moves are those of Fiduccia & Mattheyses (1982).
#pragma once

#include <vector>

namespace plumbline::least_squares {

/// Undirected, both directions stored, no loops. Weights of vertices are unknowns; those of edges say how many edges
/// of the graph it was made from one stands for.
struct Graph {
  std::vector<int> starts{0}, neighbours, edge_weights, weights;
  int size() const { return static_cast<int>(weights.size()); }
};

enum Side : char { left = 0, right = 1, between = 2 };

/// Side of every vertex; none of `left` meets one of `right`. One of the two may be empty: then there is no separator
/// worth having (of a complete graph there is none at all). Deterministic. Takes part in stop_point().
std::vector<Side> find_separator(const Graph& graph);

}  // namespace plumbline::least_squares

#include <algorithm>
#include <cmath>

#include "least_squares/sparse/order.hpp"
#include "least_squares/sparse/separator.hpp"

namespace plumbline::least_squares {
namespace {

using Lists = std::vector<std::vector<int>>;

constexpr int smallest_dissected = 120;

class Dissection {
 public:
  Dissection(const Lists& neighbours, const std::vector<int>& sizes)
      : neighbours_(neighbours), sizes_(sizes), local_(neighbours.size(), -1) {}

  std::vector<int> run() {
    // What meets very many belongs to every separator: a camera of all images, say.
    const double many = std::max(16.0, 10 * std::sqrt(static_cast<double>(neighbours_.size())));
    std::vector<int> vertices, last;
    for (int b = 0; b < static_cast<int>(neighbours_.size()); ++b) {
      if (sizes_[b] == 0) continue;
      (static_cast<double>(neighbours_[b].size()) > many ? last : vertices).push_back(b);
    }
    dissect(vertices);
    order_.insert(order_.end(), last.begin(), last.end());
    return std::move(order_);
  }

 private:
  /// Precondition: `vertices` ascending. Appends them to the order.
  void dissect(const std::vector<int>& vertices) {
    if (static_cast<int>(vertices.size()) <= smallest_dissected) return by_minimum_degree(vertices);
    const std::vector<Side> sides = find_separator(graph_of(vertices));
    std::vector<int> part[3];
    for (std::size_t k = 0; k < vertices.size(); ++k) part[sides[k]].push_back(vertices[k]);
    if (part[between].empty() ? part[left].empty() || part[right].empty() : 2 * part[between].size() > vertices.size())
      return by_minimum_degree(vertices);
    if (std::max(part[left].size(), part[right].size()) == vertices.size()) return by_minimum_degree(vertices);
    dissect(part[left]);
    dissect(part[right]);
    order_.insert(order_.end(), part[between].begin(), part[between].end());
  }

  void by_minimum_degree(const std::vector<int>& vertices) {
    Lists own(vertices.size());
    number(vertices);
    for (std::size_t k = 0; k < vertices.size(); ++k)
      for (int other : neighbours_[vertices[k]])
        if (local_[other] >= 0) own[k].push_back(local_[other]);
    forget(vertices);
    for (int k : minimum_degree_order(own)) order_.push_back(vertices[k]);
  }

  Graph graph_of(const std::vector<int>& vertices) {
    Graph graph;
    number(vertices);
    for (int v : vertices) {
      for (int other : neighbours_[v])
        if (local_[other] >= 0) graph.neighbours.push_back(local_[other]);
      graph.starts.push_back(static_cast<int>(graph.neighbours.size()));
      graph.weights.push_back(std::max(1, sizes_[v]));
    }
    graph.edge_weights.assign(graph.neighbours.size(), 1);
    forget(vertices);
    return graph;
  }

  void number(const std::vector<int>& vertices) {
    for (std::size_t k = 0; k < vertices.size(); ++k) local_[vertices[k]] = static_cast<int>(k);
  }
  void forget(const std::vector<int>& vertices) {
    for (int v : vertices) local_[v] = -1;
  }

  const Lists& neighbours_;
  const std::vector<int>& sizes_;
  std::vector<int> local_, order_;
};

}  // namespace

std::vector<int> nested_dissection_order(const Lists& neighbours, const std::vector<int>& sizes) {
  return Dissection(neighbours, sizes).run();
}

}  // namespace plumbline::least_squares

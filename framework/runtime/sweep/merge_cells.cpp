// Cells of a sweep as one graph: nodes that compute the same are one.
#include <algorithm>
#include <string>
#include <unordered_map>

#include "runtime/sweep/sweep_plan.hpp"

namespace plumbline::runtime {

namespace {

/// What one cell of two lets a node take, the node that serves both may take.
void join_conditions(GraphNode& node, const GraphNode& other) {
  const auto looser = [](auto a, auto b) { return a == 0 || b == 0 ? 0 : std::max(a, b); };
  node.isolate |= other.isolate;
  node.limits = {looser(node.limits.seconds, other.limits.seconds), looser(node.limits.memory, other.limits.memory)};
}

}  // namespace

MergedGraph merge_cells(const std::vector<const SweepCell*>& cells) {
  MergedGraph merged;
  std::unordered_map<std::string, size_t> known;
  for (const SweepCell* cell : cells) {
    const Graph& graph = cell->graph->graph;
    if (merged.nodes.empty()) {
      merged.graph.file = graph.file;
      merged.graph.seed = cell->seed;
    }
    std::vector<size_t> place;
    for (size_t i = 0; i < graph.nodes.size(); ++i) {
      const auto [found, added] = known.emplace(cell->graph->recipes[i], merged.graph.nodes.size());
      place.push_back(found->second);
      if (!added) {
        join_conditions(merged.graph.nodes[found->second], graph.nodes[i]);
        continue;
      }
      merged.graph.nodes.push_back(graph.nodes[i]);
      for (auto& [port, source] : merged.graph.nodes.back().inputs) source.node = place[source.node];
    }
    // One with rounds is alone in its graph; two of its nodes never have one recipe, their names are in it.
    if (graph.rounds.most > 0) merged.graph.rounds = graph.rounds;
    merged.nodes.push_back(std::move(place));
    merged.cells.push_back(cell);
  }
  return merged;
}

}  // namespace plumbline::runtime

#include "runtime/run/read_for_plan.hpp"

#include <algorithm>

namespace plumbline::runtime {

namespace {

bool is_called_reader(const GraphNode& node) { return std::string(node.kind.node->kind).rfind("read.", 0) == 0; }

/// Of the graph only these nodes; they take from each other alone.
Graph part_of(const Graph& graph, const std::vector<bool>& in) {
  Graph part;
  part.file = graph.file, part.variables = graph.variables, part.seed = graph.seed;
  std::vector<size_t> place(graph.nodes.size());
  for (size_t i = 0; i < graph.nodes.size(); ++i) {
    if (!in[i]) continue;
    GraphNode node = graph.nodes[i];
    for (auto& [port, source] : node.inputs) source.node = place[source.node];
    place[i] = part.nodes.size();
    part.nodes.push_back(std::move(node));
  }
  return part;
}

}  // namespace

std::vector<bool> nodes_that_read(const Graph& graph) {
  const size_t count = graph.nodes.size();
  const std::vector<bool> changes = changes_by_round(graph);
  std::vector<bool> near(count, false), in(count, false);
  for (size_t i = 0; i < count; ++i) {
    const GraphNode& node = graph.nodes[i];
    near[i] =
        !changes[i] && (is_called_reader(node) || !node.inputs.empty()) &&
        std::all_of(node.inputs.begin(), node.inputs.end(), [&](const auto& one) { return near[one.second.node]; });
  }
  // Of what could be run, the readers and what leads to one.
  for (size_t i = count; i-- > 0;) {
    in[i] = near[i] && (in[i] || is_called_reader(graph.nodes[i]));
    if (!in[i]) continue;
    for (const auto& [port, source] : graph.nodes[i].inputs) in[source.node] = true;
  }
  return in;
}

ReadForPlan read_for_plan(const Graph& graph, const Registry& registry, Store& store) {
  const Graph part = part_of(graph, nodes_that_read(graph));
  ReadForPlan read;
  if (part.nodes.empty()) return read;
  RunOptions options;
  options.remember = false;
  Observer nobody;
  const RunResult result = execute(part, registry, store, options, nobody);
  for (size_t i = 0; i < part.nodes.size(); ++i) {
    const std::string& name = part.nodes[i].name;
    const NodeResult& node = result.nodes[i];
    if (node.status == NodeStatus::failed) read.failures[name] = node.error;
    if (!is_good(node)) continue;
    if (node.status == NodeStatus::executed && part.nodes[i].kind.node->deterministic) read.executed.push_back(name);
    read.outputs[name] = node.outputs;
  }
  return read;
}

}  // namespace plumbline::runtime

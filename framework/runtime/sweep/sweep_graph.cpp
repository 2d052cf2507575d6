#include "runtime/sweep/sweep_graph.hpp"

#include <algorithm>

#include "runtime/run/key.hpp"

namespace plumbline::runtime {

namespace {

/// What comes from other rounds, and how many there may be.
void add_rounds(const Graph& graph, const GraphNode& node, KeyFields& fields) {
  for (const auto& [port, name] : node.carried) fields["carried " + port] = name;
  for (const auto& [port, name] : node.collected) fields["collected " + port] = name;
  if (node.carried.empty() && node.collected.empty()) return;
  // Named: what is kept of a cell has the inputs of the first round.
  std::string text = "first inputs, at most " + std::to_string(graph.rounds.most) +
                     (graph.rounds.until ? "\n" + graph.rounds.until->text : "");
  for (const Carry& carry : graph.rounds.carry) {
    text += "\n" + carry.name + " " + graph.nodes[carry.next.node].name + "." + carry.next.port;
    if (carry.first) text += " " + graph.nodes[carry.first->node].name + "." + carry.first->port;
  }
  fields["rounds"] = text;
}

}  // namespace

std::set<std::string> measured_nodes(const SweepFile& file) {
  std::set<std::string> nodes;
  for (const auto& [quantity, metric] : file.measure) nodes.insert(metric.substr(0, metric.find('.')));
  return nodes;
}

std::vector<bool> leading_to(const Graph& graph, const std::set<std::string>& wanted) {
  std::vector<bool> needed(graph.nodes.size(), false);
  if (graph.rounds.most > 0) needed = needed_by_rounds(graph, graph.rounds);
  for (size_t i = graph.nodes.size(); i-- > 0;) {
    if (wanted.count(graph.nodes[i].name)) needed[i] = true;
    if (needed[i])
      for (const auto& [port, source] : graph.nodes[i].inputs) needed[source.node] = true;
  }
  return needed;
}

Graph reduced(const Graph& graph, const std::set<std::string>& wanted) {
  const std::vector<bool> needed = leading_to(graph, wanted);
  Graph result = graph;
  result.nodes.clear();
  result.outputs.clear();
  std::vector<size_t> place(graph.nodes.size());
  for (size_t i = 0; i < graph.nodes.size(); ++i) {
    if (!needed[i]) continue;
    place[i] = result.nodes.size();
    result.nodes.push_back(graph.nodes[i]);
    for (auto& [port, source] : result.nodes.back().inputs) source.node = place[source.node];
  }
  for (Carry& carry : result.rounds.carry) {
    carry.next.node = place[carry.next.node];
    if (carry.first) carry.first->node = place[carry.first->node];
  }
  if (result.rounds.until) result.rounds.until->node = place[result.rounds.until->node];
  return result;
}

std::vector<std::string> recipes_of(const Graph& graph, FileHashes& hashes) {
  std::vector<std::string> recipes;
  for (const GraphNode& node : graph.nodes) {
    KeyFields fields = key_fields(node, hashes);
    fields["name"] = node.name;
    add_rounds(graph, node, fields);
    for (const auto& [port, source] : node.inputs) {
      std::string& text = fields["input " + port];
      text += (text.empty() ? "" : " ") + recipes[source.node] + "." + source.port;
    }
    recipes.push_back(key_of(fields));
  }
  return recipes;
}

bool names_seed(const Graph& graph) {
  const auto names = [](const std::string& text) { return text.find("seed}") != std::string::npos; };
  return std::any_of(graph.sources.begin(), graph.sources.end(), [&](const auto& s) { return names(s.text); }) ||
         std::any_of(graph.overrides.begin(), graph.overrides.end(), names);
}

}  // namespace plumbline::runtime

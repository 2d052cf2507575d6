#include "runtime/sweep/sweep_measures.hpp"

#include <algorithm>
#include <cstring>
#include <optional>

namespace plumbline::runtime {

namespace {

/// The end of a connection that a measure names, seen from the judged node; nothing if it is not connected.
std::optional<Source> source_of(const Graph& graph, size_t judged, const std::string& from) {
  const GraphNode& node = graph.nodes[judged];
  const std::string port = from.substr(from.find('.') + 1);
  if (from.rfind("out.", 0) == 0)
    return node.kind.output(port) ? std::make_optional(Source{judged, port, node.at}) : std::nullopt;
  const auto found = node.inputs.find(port);
  return node.inputs.count(port) == 1 ? std::make_optional(found->second) : std::nullopt;
}

bool fits(const Graph& graph, const plumbline_port& port, const Source& source) {
  const GraphNode& from = graph.nodes[source.node];
  const bool is_list = from.output_is_list.at(source.port), takes_list = port.cardinality == PLUMBLINE_LIST;
  return std::strcmp(port.type, from.kind.output(source.port)->type) == 0 && (takes_list || !is_list);
}

/// The measuring node, connected; nothing if it lacks an input.
std::optional<GraphNode> measuring_node(const Graph& graph, size_t judged, const RoleMeasure& measure,
                                        const Registry& registry) {
  const Kind* kind = registry.find(measure.use);
  if (!kind) return std::nullopt;
  GraphNode node;
  node.name = measure.quantity;
  node.kind = *kind;
  node.at = graph.nodes[judged].at;
  for (uint32_t i = 0; i < kind->node->param_count; ++i) {
    const plumbline_param& param = *kind->node->params[i];
    if (!param.default_text) return std::nullopt;
    const auto from = measure.parameters.find(param.name);
    const auto& own = graph.nodes[judged].parameters;
    const auto given = from == measure.parameters.end() ? own.end() : own.find(from->second);
    node.parameters[param.name] = given == own.end() ? param.default_text : given->second;
  }
  for (uint32_t i = 0; i < kind->node->input_count; ++i) {
    const plumbline_port& port = *kind->node->inputs[i];
    const auto from = measure.inputs.find(port.name);
    const auto source = from == measure.inputs.end() ? std::nullopt : source_of(graph, judged, from->second);
    if (source && fits(graph, port, *source))
      node.inputs.emplace(port.name, *source);
    else if (source || port.cardinality != PLUMBLINE_OPTIONAL)
      return std::nullopt;
  }
  for (uint32_t i = 0; i < kind->node->output_count; ++i) {
    const plumbline_port& port = *kind->node->outputs[i];
    node.output_is_list[port.name] = port.cardinality == PLUMBLINE_LIST;
    node.output_frames[port.name] = "";
  }
  return node;
}

bool has_node(const Graph& graph, const std::string& name) {
  return std::any_of(graph.nodes.begin(), graph.nodes.end(), [&](const GraphNode& n) { return n.name == name; });
}

}  // namespace

std::map<std::string, std::string> add_role_measures(Graph& graph, const std::set<std::string>& compared,
                                                     const std::map<std::string, std::string>& given,
                                                     const Registry& registry, std::set<std::string>& judged) {
  std::map<std::string, std::string> added;
  std::map<std::string, std::vector<size_t>> by_role;
  for (size_t i = 0; i < graph.nodes.size(); ++i)
    if (compared.count(graph.nodes[i].name) && *graph.nodes[i].kind.node->role)
      by_role[graph.nodes[i].kind.node->role].push_back(i);
  for (const auto& [name, nodes] : by_role) {
    const auto role = registry.roles().all().find(name);
    if (nodes.size() != 1 || role == registry.roles().all().end()) continue;
    for (const RoleMeasure& measure : role->second.measures) {
      if (given.count(measure.quantity) || has_node(graph, measure.quantity)) continue;
      auto node = measuring_node(graph, nodes[0], measure, registry);
      if (!node) continue;
      graph.nodes.push_back(std::move(*node));
      added[measure.quantity] = measure.quantity + "." + measure.metric;
      judged.insert(graph.nodes[nodes[0]].name);
    }
  }
  return added;
}

}  // namespace plumbline::runtime

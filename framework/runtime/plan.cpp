#include "runtime/plan.hpp"

namespace plumbline::runtime {

namespace {

/// Looks the items up; fills `outputs` if all are there.
void look_up_items(const Graph& graph, const GraphNode& node, Store& store, const KeyFields& fixed,
                   const std::map<std::string, Hashes>& inputs, PlannedNode& planned,
                   std::map<std::string, Hashes>& outputs) {
  planned.items = node.maps ? inputs.at(node.each_port).size() : 1;
  for (uint32_t i = 0; i < node.kind.node->output_count; ++i) outputs[node.kind.node->outputs[i]->name];
  for (size_t item = 0; item < planned.items; ++item) {
    KeyFields fields = fixed;
    add_inputs(fields, inputs_of_item(node, inputs, item));
    const Stored stored = look_up(store, key_of(fields), seed_of(graph.seed, node.name, item));
    if (stored.key.empty()) {
      ++planned.items_to_run;
      if (!stored.damage.empty()) planned.reasons.push_back("its stored result cannot be used: " + stored.damage);
      continue;
    }
    for (const auto& [port, hashes] : stored.run.outputs)
      outputs[port].insert(outputs[port].end(), hashes.begin(), hashes.end());
  }
  planned.runs = planned.items_to_run > 0;
}

void explain(const GraphNode& node, const Graph& graph, KeyFields now, const std::map<std::string, KeyFields>& last,
             PlannedNode& planned) {
  if (!planned.reasons.empty()) return;
  const auto before = last.find(node.name);
  if (before == last.end()) {
    planned.reasons.push_back("never ran in this pipeline");
    return;
  }
  if (before->second.count("seed")) now["seed"] = std::to_string(graph.seed);
  planned.reasons = compare(before->second, now);
  if (planned.reasons.empty()) planned.reasons.push_back("its result is not in the store any more");
}

}  // namespace

std::vector<PlannedNode> plan(const Graph& graph, Store& store) {
  const auto last = last_keys(store, graph);
  std::vector<PlannedNode> result(graph.nodes.size());
  std::vector<std::map<std::string, Hashes>> outputs(graph.nodes.size());
  for (size_t i = 0; i < graph.nodes.size(); ++i) {
    const GraphNode& node = graph.nodes[i];
    PlannedNode& planned = result[i];
    for (const auto& [port, source] : node.inputs)
      if (result[source.node].runs)
        planned.reasons.push_back("its input '" + port + "' will be recomputed by '" + graph.nodes[source.node].name +
                                  "'");
    if (!planned.reasons.empty()) {
      planned.runs = true;
      continue;
    }
    if (!node.kind.node->deterministic) {
      planned.runs = true;
      planned.reasons.push_back("it is not deterministic and always runs");
      continue;
    }
    const auto inputs = inputs_of(node, outputs);
    KeyFields fields;
    try {
      fields = key_fields(node, store.file_hashes());
    } catch (const std::exception& error) {
      planned.runs = true;
      planned.reasons.push_back(error.what());
      continue;
    }
    look_up_items(graph, node, store, fields, inputs, planned, outputs[i]);
    if (!planned.runs) continue;
    add_inputs(fields, inputs);
    explain(node, graph, fields, last, planned);
  }
  return result;
}

}  // namespace plumbline::runtime

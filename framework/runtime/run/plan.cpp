#include "runtime/run/plan.hpp"

#include "runtime/run/rounds.hpp"

namespace plumbline::runtime {

namespace {

using LastKeys = std::map<std::string, KeyFields>;

/// What is known of a node that is reused.
struct Found {
  std::map<std::string, Hashes> outputs;
  std::vector<Metric> metrics;
  bool drew_seed = false;
  bool known = false;  ///< its outputs are known, though it runs
};

struct PlannedGraph {
  std::vector<PlannedNode> nodes;
  std::vector<Found> found;
};

/// Looks the items up; fills `found` if all are there.
void look_up_items(const Graph& graph, const GraphNode& node, Store& store, const KeyFields& fixed,
                   const std::map<std::string, Hashes>& inputs, PlannedNode& planned, Found& found) {
  planned.items = node.maps ? inputs.at(node.each_port).size() : 1;
  for (uint32_t i = 0; i < node.kind.node->output_count; ++i) found.outputs[node.kind.node->outputs[i]->name];
  for (size_t item = 0; item < planned.items; ++item) {
    KeyFields fields = fixed;
    add_inputs(fields, inputs_of_item(node, inputs, item));
    const std::string key = key_of(fields);
    const Stored stored = look_up(store, key, seed_of(graph.seed, node.name, item, node.round));
    if (stored.key.empty()) {
      ++planned.items_to_run;
      if (!stored.outdated.empty()) planned.reasons.push_back(stored.outdated);
      if (!stored.damage.empty()) planned.reasons.push_back("its stored result cannot be used: " + stored.damage);
      continue;
    }
    found.drew_seed = found.drew_seed || stored.key != key;
    found.metrics.insert(found.metrics.end(), stored.run.metrics.begin(), stored.run.metrics.end());
    for (const auto& [port, hashes] : stored.run.outputs)
      found.outputs[port].insert(found.outputs[port].end(), hashes.begin(), hashes.end());
  }
  planned.runs = planned.items_to_run > 0;
}

void explain(const GraphNode& node, const Graph& graph, KeyFields now, const LastKeys& last, PlannedNode& planned) {
  if (!planned.reasons.empty()) return;
  const auto before = last.find(label_of(node));
  if (before == last.end()) {
    planned.reasons.push_back("never ran in this pipeline");
    return;
  }
  if (before->second.count("seed")) now["seed"] = std::to_string(graph.seed);
  planned.reasons = compare(before->second, now);
  if (planned.reasons.empty()) planned.reasons.push_back("its result is not in the store any more");
}

PlannedGraph plan_graph(const Graph& graph, Store& store, const LastKeys& last, const ReadForPlan& read) {
  PlannedGraph result{std::vector<PlannedNode>(graph.nodes.size()), std::vector<Found>(graph.nodes.size())};
  std::vector<std::map<std::string, Hashes>> outputs(graph.nodes.size());
  for (size_t i = 0; i < graph.nodes.size(); ++i) {
    const GraphNode& node = graph.nodes[i];
    PlannedNode& planned = result.nodes[i];
    planned.node = i;
    planned.round = node.round;
    for (const auto& [port, source] : node.inputs)
      if (result.nodes[source.node].runs && !result.found[source.node].known)
        planned.reasons.push_back("its input '" + port + "' will be recomputed by '" + graph.nodes[source.node].name +
                                  "'");
    if (!planned.reasons.empty()) {
      planned.runs = true;
      planned.is_sure = !node.kind.node->deterministic;
      continue;
    }
    if (!node.kind.node->deterministic) {
      planned.runs = true;
      planned.reasons.push_back("it is not deterministic and always runs");
      if (const auto now = read.outputs.find(node.name); now != read.outputs.end()) {
        result.found[i].known = true;
        result.found[i].outputs = outputs[i] = now->second;
      }
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
    look_up_items(graph, node, store, fields, inputs, planned, result.found[i]);
    outputs[i] = result.found[i].outputs;
    if (!planned.runs) continue;
    add_inputs(fields, inputs);
    explain(node, graph, fields, last, planned);
  }
  return result;
}

/// Round by round, as long as all of it is in the store.
std::vector<PlannedNode> plan_rounds(const Graph& graph, Store& store, const LastKeys& last, const ReadForPlan& read) {
  std::vector<PlannedNode> all;
  RoundsCourse course(graph);
  const auto take = [&](const RoundsCourse::Stage& stage) {
    PlannedGraph planned = plan_graph(stage.graph, store, last, read);
    bool known = true;
    for (size_t i = 0; i < stage.nodes.size(); ++i) {
      PlannedNode& node = planned.nodes[i];
      node.node = stage.nodes[i];
      const bool there = !node.runs || planned.found[i].known;
      known = known && there;
      if (there) course.put(node.node, planned.found[i].outputs, planned.found[i].metrics, planned.found[i].drew_seed);
      all.push_back(std::move(node));
    }
    return known;
  };
  RoundsEnd end;
  bool known = true;
  while (!end.over && (known = take(course.round()))) end = course.judge();
  std::vector<size_t> unknown;
  take(course.rest(known, unknown));
  for (const size_t node : unknown)
    all.push_back({node,
                   0,
                   true,
                   false,
                   0,
                   0,
                   {"it comes after the rounds, of which number " + std::to_string(course.number()) +
                    " is still to be computed"}});
  return all;
}

}  // namespace

std::vector<PlannedNode> plan(const Graph& graph, Store& store, const ReadForPlan& read) {
  const LastKeys last = last_keys(store, graph);
  return graph.rounds.most > 0 ? plan_rounds(graph, store, last, read) : plan_graph(graph, store, last, read).nodes;
}

}  // namespace plumbline::runtime

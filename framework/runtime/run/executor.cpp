#include "runtime/run/executor.hpp"

#include <algorithm>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>

#include "runtime/base/digest.hpp"
#include "runtime/base/json_text.hpp"
#include "runtime/base/running_nodes.hpp"
#include "runtime/run/graph_run.hpp"
#include "runtime/run/rounds.hpp"

namespace plumbline::runtime {

const char* to_text(NodeStatus status) {
  static constexpr const char* names[] = {"executed", "reused", "failed", "skipped", "cancelled"};
  return names[static_cast<int>(status)];
}

const char* to_text(plumbline_answer failure) {
  return failure == PLUMBLINE_BAD_INPUT ? "bad_input" : failure == PLUMBLINE_NOT_CONVERGED ? "not_converged" : "failed";
}

bool is_good(const NodeResult& result) {
  return result.status == NodeStatus::executed || result.status == NodeStatus::reused;
}

size_t RunResult::count(NodeStatus status) const {
  const auto has_it = [&](const NodeResult& node) { return node.status == status; };
  size_t count = static_cast<size_t>(std::count_if(nodes.begin(), nodes.end(), has_it));
  for (const EarlierRound& node : earlier) count += has_it(node.result);
  return count;
}

bool RunResult::ok() const {
  return !cancelled && rounds.problem.empty() && std::all_of(nodes.begin(), nodes.end(), is_good);
}

bool RunResult::usable() const {
  const auto invalid = [](const NodeResult& node) {
    return std::any_of(node.metrics.begin(), node.metrics.end(),
                       [](const Metric& metric) { return metric.name == "invalid" && metric.value > 0; });
  };
  return ok() && (rounds.rounds == 0 || rounds.finished) && std::none_of(nodes.begin(), nodes.end(), invalid);
}

bool RunResult::not_converged() const {
  return rounds.problem.empty() && count(NodeStatus::failed) > 0 &&
         std::all_of(nodes.begin(), nodes.end(), [](const NodeResult& node) {
           return node.status != NodeStatus::failed || node.failure == PLUMBLINE_NOT_CONVERGED;
         });
}

std::map<std::string, Hashes> inputs_of(const GraphNode& node,
                                        const std::vector<std::map<std::string, Hashes>>& outputs_of_nodes) {
  std::map<std::string, Hashes> inputs;
  for (const auto& [port, source] : node.inputs) {
    const Hashes& given = outputs_of_nodes[source.node].at(source.port);
    Hashes& all = inputs[port];
    all.insert(all.end(), given.begin(), given.end());
  }
  for (const auto& [port, hashes] : node.given) inputs[port] = hashes;
  return inputs;
}

std::map<std::string, Hashes> inputs_of_item(const GraphNode& node, const std::map<std::string, Hashes>& inputs,
                                             size_t item) {
  std::map<std::string, Hashes> result;
  for (const auto& [port, hashes] : inputs)  // not a copy of all: with many items that would grow with their square
    result[port] = node.maps && port == node.each_port ? Hashes{hashes[item]} : hashes;
  return result;
}

std::string pipeline_id(const Graph& graph) {
  const std::string path = std::filesystem::absolute(graph.file).lexically_normal().string();
  return sha256_of(path.data(), path.size());
}

std::map<std::string, KeyFields> last_keys(const Store& store, const Graph& graph) {
  const auto json = nlohmann::json::parse(store.pipeline_note(pipeline_id(graph)), nullptr, false);
  std::map<std::string, KeyFields> keys;
  if (!json.is_object()) return keys;
  try {
    json.get_to(keys);
  } catch (const nlohmann::json::exception&) {
    keys.clear();  // a damaged note costs only the explanation
  }
  return keys;
}

namespace {

/// What ran, by label.
using Ran = std::map<std::string, const NodeResult*>;

/// A node that failed keeps what the note says of its last good run.
void remember_keys(Store& store, const Graph& graph, const Ran& ran) {
  const bool all_good = std::all_of(ran.begin(), ran.end(), [](const auto& entry) { return is_good(*entry.second); });
  const auto before = all_good ? std::map<std::string, KeyFields>() : last_keys(store, graph);
  JsonText json;
  json.open('{');
  for (const auto& [label, result] : ran) {
    const auto old = before.find(label);
    const bool good = is_good(*result);
    if (!good && old == before.end()) continue;
    json.name(label).open('{');
    for (const auto& [field, value] : good ? result->fields : old->second) json.field(field, value);
    json.close('}');
  }
  const std::string id = pipeline_id(graph), text = json.close('}').take() + "\n";
  if (store.pipeline_note(id) != text) store.put_pipeline_note(id, text);
}

/// Runs the rounds one after the other, then what comes after them.
class RoundsRun {
 public:
  RoundsRun(const Graph& graph, const Registry& registry, Store& store, const RunOptions& options, Observer& observer)
      : graph_(graph), registry_(registry), store_(store), options_(options), observer_(observer), course_(graph) {
    result_.nodes.resize(graph.nodes.size());
    round_of_.assign(graph.nodes.size(), 0);
  }

  RunResult run() {
    bool known = true;
    do {
      known = run_stage(course_.round());
      if (!known) break;
      result_.rounds = course_.judge();
      observer_.round_finished(result_.rounds);
      known = result_.rounds.problem.empty();
    } while (!result_.rounds.over);
    std::vector<size_t> unknown;
    const RoundsCourse::Stage rest = course_.rest(known, unknown);
    for (const size_t node : unknown) skip(node);
    if (!result_.cancelled) run_stage(rest);
    return std::move(result_);
  }

 private:
  bool run_stage(const RoundsCourse::Stage& stage) {
    RunResult part = run_graph(stage.graph, registry_, store_, options_, observer_);
    for (size_t i = 0; i < stage.nodes.size(); ++i) {
      const size_t node = stage.nodes[i];
      NodeResult& now = part.nodes[i];
      if (is_good(now)) course_.put(node, now.outputs, now.metrics, now.fields.count("seed") > 0);
      if (now.status == NodeStatus::failed && failed_.empty()) failed_ = graph_.nodes[node].name;
      if (round_of_[node] > 0) result_.earlier.push_back({node, round_of_[node], std::move(result_.nodes[node])});
      round_of_[node] = std::max<size_t>(stage.graph.nodes[i].round, 1);
      result_.nodes[node] = std::move(now);
    }
    result_.cancelled = result_.cancelled || part.cancelled;
    return part.ok();
  }

  void skip(size_t index) {
    NodeResult& result = result_.nodes[index];
    result.status = result_.cancelled ? NodeStatus::cancelled : NodeStatus::skipped;
    result.cause = failed_;
    result.error = result_.cancelled ? ""
                   : failed_.empty() ? "it comes after the rounds, which did not come to an end"
                                     : "it comes after the rounds, in which '" + failed_ + "' failed";
    observer_.node_finished(graph_.nodes[index], result);
  }

  const Graph& graph_;
  const Registry& registry_;
  Store& store_;
  const RunOptions& options_;
  Observer& observer_;
  RoundsCourse course_;
  RunResult result_;
  std::vector<size_t> round_of_;  // in which a node ran last; 0: not yet
  std::string failed_;
};

}  // namespace

RunResult execute(const Graph& graph, const Registry& registry, Store& store, const RunOptions& options,
                  Observer& observer) {
  name_nodes_that_end_the_process();
  RunResult result = graph.rounds.most > 0 ? RoundsRun(graph, registry, store, options, observer).run()
                                           : run_graph(graph, registry, store, options, observer);
  if (!options.remember) return result;
  Ran ran;
  for (const RunResult::EarlierRound& node : result.earlier)
    ran[label_of(graph.nodes[node.node].name, node.round)] = &node.result;
  for (size_t i = 0; i < result.nodes.size(); ++i)
    ran[label_of(graph.nodes[i].name, result.nodes[i].round)] = &result.nodes[i];
  try {
    remember_keys(store, graph, ran);
  } catch (const StoreError&) {  // the note only explains the next plan
  }
  return result;
}

}  // namespace plumbline::runtime

#include "runtime/sweep/sweep_job.hpp"

#include <unistd.h>

#include <memory>
#include <set>

#include "runtime/base/digest.hpp"
#include "runtime/plugins/executable_node.hpp"
#include "runtime/plugins/library.hpp"
#include "runtime/run/executor.hpp"

namespace plumbline::runtime {

namespace fs = std::filesystem;

namespace {

std::string hash_of(const std::map<std::string, Hashes>& inputs) {
  Sha256 hash;
  for (const auto& [port, hashes] : inputs) {
    hash.add_field(port);
    for (const std::string& item : hashes) hash.add_field(item);
  }
  return hash.hex().substr(0, 16);
}

/// What a node got, in one hash; inputs that kinds of its role may lack each by itself, as `node.port`.
void add_inputs_of(const std::string& name, const plumbline_node& kind, const Roles& roles, const NodeResult& result,
                   CellRecord& record) {
  if (result.inputs.empty()) return;
  std::map<std::string, Hashes> all_have;
  for (const auto& input : result.inputs) {
    if (roles.may_lack(kind, input.first))
      record.inputs[name + "." + input.first] = hash_of({input});
    else
      all_have.insert(input);
  }
  record.inputs[name] = hash_of(all_have);
}

/// A node that runs once for each item gives as many values of a metric: none of them is that of the cell. Whether a
/// result may be used is another matter: one that may not is enough.
void add_metrics(const GraphNode& node, const NodeResult& result, CellRecord& record) {
  for (const Metric& metric : result.metrics) {
    if (node.maps && metric.name != "invalid") continue;
    Metric& kept = record.metrics[node.name + "." + metric.name];
    if (!(node.maps && kept.value > metric.value)) kept = metric;
  }
}

CellRecord record_of(const SweepCell& cell, const std::vector<size_t>& nodes, const RunResult& run,
                     const Roles& roles) {
  CellRecord record;
  record.host = this_host();
  for (size_t i = 0; i < nodes.size(); ++i) {
    const NodeResult& result = run.nodes[nodes[i]];
    const std::string& name = cell.graph->graph.nodes[i].name;
    if (result.status == NodeStatus::failed && !cell.graph->essential[i]) {
      record.warnings.push_back(result.error);  // a bound that does not exist takes nothing from the result
    } else if (result.status == NodeStatus::failed && !record.failed) {
      record.failed = true;
      record.error = result.error;
      record.failed_node = name;
    }
    add_metrics(cell.graph->graph.nodes[i], result, record);
    for (const std::string& warning : result.warnings) record.warnings.push_back(name + ": " + warning);
    add_inputs_of(name, *cell.graph->graph.nodes[i].kind.node, roles, result, record);
    if (result.status == NodeStatus::executed) record.seconds[name] = result.item_seconds;
  }
  std::set<size_t> in_first_round;
  for (const RunResult::EarlierRound& node : run.earlier) {
    const std::string& name = cell.graph->graph.nodes[node.node].name;
    record.seconds[name] += node.result.item_seconds;
    // What a loop starts from is what its first round gets; later ones get what it made of that.
    if (in_first_round.insert(node.node).second)
      add_inputs_of(name, *cell.graph->graph.nodes[node.node].kind.node, roles, node.result, record);
  }
  if (run.rounds.rounds > 0) {
    record.metrics["rounds.number"] = {"number", static_cast<double>(run.rounds.rounds), "1"};
    record.metrics["rounds.finished"] = {"finished", run.rounds.finished ? 1.0 : 0.0, "1"};
  }
  if (!run.rounds.problem.empty() && !record.failed) {
    record.failed = true;
    record.error = run.rounds.problem;
  }
  return record;
}

/// One graph for the cells that are ordinary ones, and one for each that has rounds.
std::vector<MergedGraph> graphs_of(const std::vector<const SweepCell*>& cells) {
  std::vector<const SweepCell*> ordinary;
  std::vector<MergedGraph> graphs;
  for (const SweepCell* cell : cells) {
    if (cell->graph->graph.rounds.most == 0)
      ordinary.push_back(cell);
    else
      graphs.push_back(merge_cells({cell}));
  }
  if (!ordinary.empty()) graphs.push_back(merge_cells(ordinary));
  return graphs;
}

std::string sha256_of_existing(const fs::path& file) {
  try {
    return sha256_of_file(file);
  } catch (const std::exception&) {
    return "absent";
  }
}

constexpr size_t largest_in_memory = size_t{4} << 20;  ///< of what a node hands on, where only results are kept

}  // namespace

std::string this_host() {
  char host[65] = "host";
  gethostname(host, sizeof host - 1);
  return host;
}

std::vector<std::string> changed_plugins(const Graph& graph) {
  std::set<std::string> changed;
  for (const GraphNode& node : graph.nodes) {
    const Plugin* plugin = node.kind.plugin;
    if (plugin->executable) {
      for (const auto& [file, identity] : plugin->executable->identities)
        if (file_identity(file) != identity) changed.insert(file.string());
    } else if (file_identity(plugin->identity.path) != plugin->file_identity &&
               sha256_of_existing(plugin->identity.path) != plugin->sha256) {
      changed.insert(plugin->identity.path.string());
    }
  }
  return {changed.begin(), changed.end()};
}

SweepAnswer run_sweep_job(const SweepPlan& plan, const SweepJob& job, const Registry& registry, Store& store,
                          const fs::path& scratch, int threads, uint64_t memory, const std::atomic<bool>* cancel) {
  std::vector<const SweepCell*> cells;
  for (const size_t index : job.cells) cells.push_back(&plan.cells[index]);
  SweepAnswer answer;
  std::unique_ptr<Store> thrown_away;
  const fs::path own = scratch / std::to_string(getpid());
  if (!plan.file.keep_everything) {
    thrown_away = std::make_unique<Store>(own);
    thrown_away->keep_in_memory(largest_in_memory);
  }
  RunOptions options;
  options.threads = threads;
  options.memory = memory;
  options.cancel = cancel;
  options.remember = false;
  std::vector<std::pair<const SweepCell*, CellRecord>> done;
  for (const MergedGraph& merged : graphs_of(cells)) {
    Observer silent;
    const RunResult run = execute(merged.graph, registry, thrown_away ? *thrown_away : store, options, silent);
    for (size_t c = 0; c < merged.cells.size(); ++c) {
      answer.nodes += merged.nodes[c].size();
      done.emplace_back(merged.cells[c], record_of(*merged.cells[c], merged.nodes[c], run, registry.roles()));
    }
    answer.merged += merged.graph.nodes.size();
    answer.executed += run.count(NodeStatus::executed);
    answer.cancelled = answer.cancelled || run.cancelled;
  }
  thrown_away.reset();
  std::error_code ignored;
  if (!plan.file.keep_everything) fs::remove_all(own, ignored);
  if (answer.cancelled) return answer;
  const CellRecords records(store);
  for (auto& [cell, record] : done) {
    record.run = job.run;
    if (record.failed && !changed_plugins(cell->graph->graph).empty()) {
      answer.plugins_changed = true;
      continue;
    }
    answer.failed += record.failed;
    records.put(cell->key, record);
  }
  return answer;
}

}  // namespace plumbline::runtime

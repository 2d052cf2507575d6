#include "runtime/sweep/sweep_table.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <thread>

#include "runtime/base/json_text.hpp"
#include "runtime/base/near_names.hpp"
#include "runtime/plugins/linked_files.hpp"
#include "runtime/sweep/sweep_job.hpp"

namespace plumbline::runtime {

using Json = nlohmann::ordered_json;

namespace {

std::string processor() {
  std::ifstream stream("/proc/cpuinfo");
  for (std::string line; std::getline(stream, line);)
    if (line.rfind("model name", 0) == 0 && line.find(": ") != std::string::npos)
      return line.substr(line.find(": ") + 2);
  return "unknown processor";
}

Json groups_of(const SweepPlan& plan) {
  Json groups = Json::array();
  for (const SweepGroup& group : plan.file.groups) {
    Json json;
    json["name"] = group.name;
    bool whole_pipelines = false;
    for (const SweepAlternative& alternative : group.alternatives) {
      json["alternatives"].push_back(alternative.name);
      whole_pipelines |= !alternative.pipeline.empty();
    }
    const auto nodes = plan.swapped.find(group.name);
    json["nodes"] = nodes == plan.swapped.end() ? std::vector<std::string>() : nodes->second;
    json["whole_pipelines"] = whole_pipelines;
    groups.push_back(std::move(json));
  }
  return groups;
}

/// What the node of the error says of parts of the errors, as metrics "scale_found" and "scale_predicted" [m],
/// "scale_nees" and "scale_freedom": whoever gives all four of a name has its covariance judged by it.
Json modes_of(const CellRecord& record, const std::string& error) {
  Json modes = Json::object();
  const std::string node = error.substr(0, error.find('.') + 1), found = "_found";
  for (const auto& [name, metric] : record.metrics) {
    if (name.compare(0, node.size(), node) != 0 || name.size() < node.size() + found.size()) continue;
    if (name.compare(name.size() - found.size(), found.size(), found) != 0) continue;
    const std::string mode = name.substr(0, name.size() - found.size());
    Json parts{{"found", metric.value}};
    for (const char* part : {"predicted", "nees", "freedom"})
      if (const auto other = record.metrics.find(mode + "_" + part); other != record.metrics.end())
        parts[part] = other->second.value;
    if (parts.size() == 4) modes[mode.substr(node.size())] = parts;
  }
  return modes;
}

/// Cells of these seeds are judged. A bench with looks is judged at its looks and nowhere between them: each has its
/// share of the error probability, and what else there is, from a run that was cut off, has none.
std::set<uint64_t> judged_seeds(const SweepPlan& plan, const CellRecords& records, size_t count) {
  const SweepFile& file = plan.file;
  const auto first = [&](size_t n) {
    return std::set<uint64_t>(file.seeds.begin(),
                              file.seeds.begin() + static_cast<std::ptrdiff_t>(std::min(n, file.seeds.size())));
  };
  if (count > 0) return first(count);
  if (file.looks.empty()) return first(file.seeds.size());
  std::set<uint64_t> open;  // seeds of which a cell has not run
  for (const SweepCell& cell : plan.cells)
    if (!records.find(cell.key)) open.insert(cell.seed);
  size_t look = file.looks.front();
  for (const size_t next : file.looks) {
    const std::set<uint64_t> of_look = first(next);
    if (std::any_of(of_look.begin(), of_look.end(), [&](uint64_t seed) { return open.count(seed) > 0; })) break;
    look = next;
  }
  return first(look);
}

/// Why `plumbline run` would forbid to use what a cell found; empty if it would not.
std::string refusal_of(const SweepCell& cell, const CellRecord& record) {
  const auto above = [&](const std::string& name, double limit) {
    const auto metric = record.metrics.find(name);
    return metric != record.metrics.end() && metric->second.value > limit;
  };
  if (record.metrics.count("rounds.finished") && !above("rounds.finished", 0))
    return "its rounds did not come to an end: what there is of it is not to be used";
  for (size_t i = 0; cell.graph && i < cell.graph->graph.nodes.size(); ++i) {
    const std::string& node = cell.graph->graph.nodes[i].name;
    if (cell.graph->essential[i] && above(node + ".invalid", 0))
      return "node '" + node + "' says of its result that it is not to be used (invalid)";
  }
  return "";
}

Json cell_json(const SweepCell& cell, const std::optional<CellRecord>& record, const SweepFile& file) {
  Json json;
  json["scenario"] = cell.scenario;
  json["values"] = cell.values;
  json["choices"] = cell.choices;
  json["seed"] = cell.seed;
  const std::string failure = record ? failure_of(cell, *record, file) : "";
  if (!cell.graph) json["planned"] = false;
  json["status"] = !record ? "missing" : failure.empty() ? "done" : "failed";
  if (!record) return json;
  if (!failure.empty()) json["error"] = failure;
  if (!record->failed && !refusal_of(cell, *record).empty()) json["forbidden"] = true;
  json["measures"] = Json::object();
  for (const auto& [quantity, name] : file.measure)
    if (const auto found = record->metrics.find(name); found != record->metrics.end())
      json["measures"][quantity] = found->second.value;
  if (const Json modes = modes_of(*record, file.measure.at("error")); !modes.empty()) json["modes"] = modes;
  json["inputs"] = record->inputs;
  json["seconds"] = record->seconds;
  json["run"] = record->run;
  if (!record->warnings.empty()) json["warnings"] = record->warnings.size();
  return json;
}

}  // namespace

std::vector<std::string> libraries_of(const SweepPlan& plan, const BuildFacts& build) {
  std::set<std::string> files(build.libraries.begin(), build.libraries.end());
  for (const Graph* graph : graphs_of(plan))
    for (const GraphNode& node : graph->nodes) {
      const std::vector<std::string> linked = linked_files(*node.kind.plugin);
      files.insert(linked.begin(), linked.end());
    }
  files.erase("");
  return {files.begin(), files.end()};
}

std::string failure_of(const SweepCell& cell, const CellRecord& record, const SweepFile& file) {
  if (record.failed) return record.error;
  if (const std::string refusal = refusal_of(cell, record); !refusal.empty()) return refusal;
  const std::string& name = file.measure.at("error");
  const auto metric = record.metrics.find(name);
  if (metric == record.metrics.end()) {
    std::vector<std::string> given;
    for (const auto& [other, value] : record.metrics) given.push_back(other);
    const auto near = near_names(name, given);
    return "it gave no metric '" + name + "'" + (near.empty() ? "" : " — did you mean '" + near[0] + "'?");
  }
  if (!std::isfinite(metric->second.value)) return "it gave no finite value of '" + name + "'";
  for (const char* length : {"error", "bias", "worst", "predicted", "bound"}) {
    const auto measured = file.measure.find(length);
    const auto found = measured == file.measure.end() ? record.metrics.end() : record.metrics.find(measured->second);
    if (found != record.metrics.end() && found->second.unit != "m")
      return "'" + measured->second + "' is in '" + found->second.unit + "': '" + length +
             "' of a bench is a length in 'm', of which less is better";
  }
  return "";
}

std::string sweep_table(const SweepPlan& plan, const CellRecords& records, const Registry& registry,
                        const BuildFacts& build, size_t first_seeds) {
  const SweepFile& file = plan.file;
  Json json;
  json["title"] = file.title;
  json["file"] = file.path.filename().string();
  json["overrides"] = plan.overrides;
  json["measure"] = file.measure;
  json["rope"] = file.rope;
  json["tolerances"] = file.tolerances;
  if (file.weighted) json["weights"] = file.weights.empty() ? Json("equal") : Json(file.weights);
  if (!file.looks.empty()) json["looks"] = file.looks;
  for (const SweepScenario& scenario : file.scenarios) json["scenarios"].push_back(scenario.name);
  json["variables"] = Json::array();
  for (const SweepVariable& variable : file.matrix)
    json["variables"].push_back({{"name", variable.name}, {"values", variable.values}});
  json["groups"] = groups_of(plan);
  json["judged"] = plan.judged;
  json["excluded"] = Json::array();
  for (const ExcludedCells& cells : plan.excluded)
    json["excluded"].push_back({{"what", cells.what}, {"why", cells.why}, {"cells", cells.cells}});
  std::set<std::string> hosts;
  size_t behind = 0;
  const std::set<uint64_t> judged = judged_seeds(plan, records, first_seeds);
  json["cells"] = Json::array();
  for (const SweepCell& cell : plan.cells) {
    auto record = records.find(cell.key);
    if (record && !file.seeds.empty() && judged.count(cell.seed) == 0) record.reset(), ++behind;
    if (record && !record->host.empty()) hosts.insert(record->host);
    json["cells"].push_back(cell_json(cell, record, file));
  }
  json["judged_seeds"] = judged.size();
  json["behind"] = behind;
  Json machine;
  machine["version"] = build.version;
  machine["commit"] = build.commit;
  machine["compiler"] = build.compiler;
  machine["libraries"] = libraries_of(plan, build);
  machine["host"] = this_host();
  machine["processor"] = processor();
  machine["processors"] = std::thread::hardware_concurrency();
  machine["hosts"] = hosts;
  for (const auto& plugin : registry.plugins())
    machine["plugins"].push_back(plugin->identity.name + " " + plugin->identity.version + " " +
                                 plugin->sha256.substr(0, 12));
  json["machine"] = std::move(machine);
  return json_line(json) + "\n";
}

std::vector<SourceFile> sources_of(const SweepPlan& plan) {
  std::vector<SourceFile> sources;
  std::set<std::string> seen;
  std::set<const CellGraph*> graphs;
  for (const SweepCell& cell : plan.cells) {
    if (!cell.graph || !graphs.insert(cell.graph.get()).second) continue;
    for (const SourceFile& source : cell.graph->graph.sources)
      if (seen.insert(source.path).second) sources.push_back(source);
  }
  return sources;
}

}  // namespace plumbline::runtime

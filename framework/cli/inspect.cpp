// plumbline validate, plan, graph
#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "commands.hpp"
#include "runtime/base/printable.hpp"
#include "runtime/run/plan.hpp"
#include "terminal.hpp"

namespace plumbline::cli {

using Json = nlohmann::ordered_json;

int validate(const Options& options) {
  const runtime::Registry registry = discover();
  const auto file = find_pipeline(options.pipeline);
  try {
    const runtime::Graph graph = load_pipeline(file, options.overrides, registry, pipeline_folders());
    warn_of_kinds_offered_twice(graph, registry);
    if (options.json)
      std::printf("%s\n", Json{{"valid", true}, {"file", graph.file}, {"nodes", graph.nodes.size()}}.dump().c_str());
    else if (!options.quiet)
      std::printf("%s: valid, %zu nodes, %zu outputs\n", graph.file.c_str(), graph.nodes.size(), graph.outputs.size());
    return 0;
  } catch (const runtime::InvalidPipeline& invalid) {
    if (!options.json) {
      tell(runtime::printable(invalid.what()));
      return 1;
    }
    Json problems = Json::array();
    for (const auto& problem : invalid.problems())
      problems.push_back({{"file", problem.at.file},
                          {"line", problem.at.line},
                          {"column", problem.at.column},
                          {"message", problem.text()}});
    std::printf("%s\n", Json{{"valid", false}, {"file", file.string()}, {"problems", problems}}.dump().c_str());
    return 1;
  }
}

namespace {

/// What the totals of a plan leave out: rounds after one that is still to be computed are known to nobody.
std::string rounds_left_out(const runtime::Graph& graph, const std::vector<runtime::PlannedNode>& planned) {
  size_t last = 0;
  bool runs = false;
  for (const auto& p : planned) {
    last = std::max(last, p.round);
    runs = runs || (p.runs && p.round > 0);
  }
  if (graph.rounds.most == 0 || !runs || last >= graph.rounds.most) return {};
  return "; rounds after number " + std::to_string(last) + ", of at most " + std::to_string(graph.rounds.most) +
         ", are not in this";
}

/// Reads what lies in files and folders, where the store can take it: a photograph more decides what a run computes.
runtime::ReadForPlan read_files(const runtime::Graph& graph, const runtime::Registry& registry,
                                const Options& options) {
  try {
    runtime::Store store = open_store(options);
    return read_for_plan(graph, registry, store);
  } catch (const runtime::StoreError&) {
    return {};  // a store that cannot be written serves a plan of what it has
  }
}

std::string listed(const std::vector<std::string>& names) {
  std::string text;
  for (size_t i = 0; i < names.size(); ++i)
    text += (i == 0 ? "" : i + 1 == names.size() ? " and " : ", ") + ("'" + names[i] + "'");
  return text;
}

}  // namespace

int plan(const Options& options) {
  const runtime::Registry registry = discover();
  const runtime::Graph graph = load(options, registry);
  const auto store = open_store_to_read(options);
  const runtime::ReadForPlan read = read_files(graph, registry, options);
  auto planned = runtime::plan(graph, *store, read);
  size_t running = 0, perhaps = 0, reused = 0;
  Json json = Json::array();
  std::vector<std::vector<std::string>> rows;
  for (auto& p : planned) {
    const auto& node = graph.nodes[p.node];
    const auto failure = read.failures.find(node.name);
    if (failure != read.failures.end()) p.reasons = {"it fails"};
    const char* const action = !p.runs ? "reuse" : p.is_sure ? "run" : "perhaps";
    ++(!p.runs ? reused : p.is_sure ? running : perhaps);
    json.push_back({{"name", node.name},
                    {"kind", node.kind.node->kind},
                    {"round", p.round},
                    {"action", action},
                    {"items", p.items},
                    {"items_to_run", p.items_to_run},
                    {"reasons", p.reasons}});
    const std::string name = runtime::label_of(node.name, p.round) + " (" + node.kind.node->kind + ")";
    std::string items;
    if (p.runs && p.items > 1) items = std::to_string(p.items_to_run) + " of " + std::to_string(p.items) + " items; ";
    rows.push_back({action, name, p.reasons.empty() ? "" : items + p.reasons[0]});
    for (size_t r = 1; r < p.reasons.size(); ++r) rows.push_back({"", "", p.reasons[r]});
  }
  if (options.json) {
    std::printf("%s\n", json.dump(1).c_str());
  } else {
    std::printf("%s", columns(rows).c_str());
    // What comes after a node that runs is not looked up: it is reused if that gives what it gave before.
    const std::string counts = perhaps == 0 ? " to run, " + std::to_string(reused) + " reused"
                                            : " to run and " + std::to_string(reused) + " reused for certain; " +
                                                  std::to_string(perhaps) + (perhaps == 1 ? " runs" : " run") +
                                                  " only if what comes in is another";
    const std::string read_now =
        read.executed.empty() ? "" : "; " + listed(read.executed) + " read the files for this plan";
    std::printf("%s\n", hanging_lines(graph.file + ": " + std::to_string(running) + counts +
                                          rounds_left_out(graph, planned) + read_now,
                                      terminal_columns())
                            .c_str());
  }
  for (const auto& [name, error] : read.failures) tell(runtime::printable(error));
  return read.failures.empty() ? 0 : 1;
}

int draw(const Options& options) {
  const runtime::Registry registry = discover();
  const runtime::Graph graph = load(options, registry);
  std::printf("%s", (options.format == "mermaid" ? to_mermaid(graph) : to_dot(graph)).c_str());
  return 0;
}

}  // namespace plumbline::cli

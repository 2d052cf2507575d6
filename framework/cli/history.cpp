// plumbline why, diff, export, verify: what runs did, from their records.
#include <stdlib.h>

#include <cstdio>
#include <nlohmann/json.hpp>
#include <tuple>

#include "commands.hpp"
#include "runtime/executor.hpp"
#include "runtime/run_record.hpp"
#include "terminal.hpp"

namespace plumbline::cli {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using runtime::NodeStatus;

namespace {

void print_json(const Json& json) {
  std::printf("%s\n", json.dump(1, ' ', false, Json::error_handler_t::replace).c_str());
}

/// The record that was written last below out/.
fs::path newest_record() {
  fs::path newest;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator("out", error)) {
    const fs::path record = entry.path() / "run.jsonl";
    if (fs::is_regular_file(record) && (newest.empty() || fs::last_write_time(record) > fs::last_write_time(newest)))
      newest = record;
  }
  if (newest.empty()) throw UsageError("there is no out/*/run.jsonl here; say which run: plumbline why NODE RUN");
  return newest;
}

std::vector<std::string> reasons(const runtime::RecordedNode& node) {
  if (node.status == "reused") return {"nothing that its result depends on has changed"};
  if (node.status == "skipped") return {"'" + node.cause + "' failed"};
  if (node.status == "cancelled") return {"the run was cancelled"};
  std::vector<std::string> all = node.why;
  if (node.status == "failed") all.insert(all.begin(), node.error);
  return all;
}

/// A folder of the program's own that goes when it is done.
class OwnFolder {
 public:
  OwnFolder() {
    std::string name = (fs::temp_directory_path() / "plumbline-verify-XXXXXX").string();
    if (!mkdtemp(name.data()))
      throw std::runtime_error("cannot make a folder in " + fs::temp_directory_path().string());
    path = name;
  }
  ~OwnFolder() {
    std::error_code ignored;
    fs::remove_all(path, ignored);
  }
  OwnFolder(const OwnFolder&) = delete;
  OwnFolder& operator=(const OwnFolder&) = delete;
  fs::path path;
};

}  // namespace

int why(const Options& options) {
  const runtime::RecordedRun run =
      runtime::read_run(options.runs.empty() ? newest_record() : fs::path(options.runs[0]));
  const runtime::RecordedNode* node = run.find(options.name);
  if (!node) {
    std::vector<std::string> names;
    for (const auto& known : run.nodes) names.push_back(known.name);
    throw UsageError(run.file.string() + " has no node '" + options.name + "'" + did_you_mean(options.name, names));
  }
  const auto lines = reasons(*node);
  if (options.json) {
    print_json(
        {{"node", node->name}, {"round", node->round}, {"kind", node->kind}, {"status", node->status}, {"why", lines}});
    return 0;
  }
  std::printf("%s (%s) was %s in %s\n", runtime::label_of(node->name, node->round).c_str(), node->kind.c_str(),
              node->status.c_str(), run.file.c_str());
  for (const std::string& line : lines) std::printf("  %s\n", line.c_str());
  return 0;
}

int diff(const Options& options) {
  const runtime::Registry registry = discover();
  const runtime::RecordedRun a = runtime::read_run(options.runs.at(0)), b = runtime::read_run(options.runs.at(1));
  std::unique_ptr<runtime::Store> store;
  try {
    store = open_store_to_read(options);
  } catch (const runtime::StoreError& error) {
    std::fprintf(stderr, "warning: contents are not compared: %s\n", error.what());
  }
  const auto differences = compare_runs(a, b, options.tolerance, store.get(), registry);
  bool equal = true;
  Json json = Json::array();
  for (const auto& difference : differences) {
    equal = equal && difference.within_tolerance;
    json.push_back({{"node", difference.node},
                    {"within_tolerance", difference.within_tolerance},
                    {"differences", difference.lines}});
    if (options.json) continue;
    std::printf("%s%s\n", difference.node.c_str(), difference.within_tolerance ? " (results agree)" : "");
    for (const std::string& line : difference.lines) std::printf("  %s\n", line.c_str());
  }
  if (options.json)
    print_json({{"equal", equal}, {"nodes", json}});
  else
    std::printf("%zu of %zu nodes differ; the results %s\n", differences.size(), a.nodes.size(),
                equal ? "agree" : "do not agree");
  return equal ? 0 : 1;
}

int export_run(const Options& options) {
  const runtime::RecordedRun run = runtime::read_run(options.runs.at(0));
  std::printf("%s", (options.format == "trace" ? chrome_trace(run) : ro_crate(run)).c_str());
  return 0;
}

int verify(const Options& options) {
  const runtime::Registry registry = discover();
  const runtime::Graph graph = load(options, registry);
  const OwnFolder folder;
  std::vector<runtime::RunResult> results;
  for (const int threads : {1, options.threads > 0 ? options.threads : 2}) {
    runtime::Store store(folder.path / std::to_string(threads));
    runtime::Observer silent;
    runtime::RunOptions run_options;
    run_options.threads = threads;
    results.push_back(execute(graph, registry, store, run_options, silent));
  }
  size_t differing = 0, failed = 0, compared = 0;
  Json json = Json::array();
  const auto compare = [&](size_t i, const runtime::NodeResult& one, const runtime::NodeResult& other) {
    ++compared;
    const std::string label = runtime::label_of(graph.nodes[i].name, one.round);
    std::vector<std::string> lines;
    for (const auto* result : {&one, &other})
      if (result->status == NodeStatus::failed && lines.empty()) lines.push_back(result->error);
    failed += !lines.empty();
    if (lines.empty() && is_good(one)) {
      for (const auto& [port, hashes] : one.outputs)
        if (const auto found = other.outputs.find(port); found == other.outputs.end() || found->second != hashes)
          lines.push_back("output " + port + " differs");
      if (!graph.nodes[i].kind.node->deterministic && !lines.empty())
        lines.push_back("it says of itself that it is not deterministic");
      differing += !lines.empty();
    }
    if (lines.empty()) return;
    json.push_back({{"node", label}, {"kind", graph.nodes[i].kind.node->kind}, {"findings", lines}});
    if (options.json) return;
    std::printf("%s (%s)\n", label.c_str(), graph.nodes[i].kind.node->kind);
    for (const std::string& line : lines) std::printf("  %s\n", line.c_str());
  };
  const auto& [first, second] = std::tie(results[0], results[1]);
  for (size_t i = 0; i < std::min(first.earlier.size(), second.earlier.size()); ++i)
    compare(first.earlier[i].node, first.earlier[i].result, second.earlier[i].result);
  for (size_t i = 0; i < graph.nodes.size(); ++i) compare(i, first.nodes[i], second.nodes[i]);
  if (first.rounds.rounds != second.rounds.rounds) {
    ++differing;
    const std::string line =
        std::to_string(first.rounds.rounds) + " and " + std::to_string(second.rounds.rounds) + " rounds";
    json.push_back({{"node", "rounds"}, {"kind", ""}, {"findings", {line}}});
    if (!options.json) std::printf("%s\n", line.c_str());
  }
  for (const auto* result : {&first, &second})
    if (const std::string& problem = result->rounds.problem; !problem.empty()) {
      ++failed;
      if (!options.json) std::printf("%s\n", problem.c_str());
      break;
    }
  const bool equal = differing == 0 && failed == 0;
  if (options.json)
    print_json({{"equal", equal}, {"nodes", compared}, {"findings", json}});
  else
    std::printf("%s: %zu nodes, run twice: %s\n", graph.file.c_str(), compared,
                equal    ? "the same bits"
                : failed ? "failed"
                         : (std::to_string(differing) + " differ").c_str());
  return equal ? 0 : 1;
}

}  // namespace plumbline::cli

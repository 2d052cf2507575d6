// plumbline verify: whether the same input gives the same bits, by running a pipeline twice, or each of its nodes
// alone.
#include <fmt/core.h>
#include <stdlib.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "commands.hpp"
#include "runtime/base/printable.hpp"
#include "runtime/run/executor.hpp"

namespace plumbline::cli {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using runtime::NodeResult;
using runtime::NodeStatus;

namespace {

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

/// Numbers are what benches measure and what decides whether a result may be used. An unknown one equals another.
void compare_metrics(const std::vector<runtime::Metric>& one, const std::vector<runtime::Metric>& other,
                     std::vector<std::string>& lines) {
  if (one.size() != other.size())
    lines.push_back(fmt::format("it gives {} metrics, and {} the second time", one.size(), other.size()));
  for (size_t i = 0; i < std::min(one.size(), other.size()); ++i) {
    const auto &a = one[i], &b = other[i];
    const bool equal = a.value == b.value || (std::isnan(a.value) && std::isnan(b.value));
    if (a.name != b.name)
      lines.push_back("metric " + a.name + " is " + b.name + " the second time");
    else if (!equal || a.unit != b.unit)
      lines.push_back(fmt::format("metric {} differs: {} {} and {} {}", a.name, a.value, a.unit, b.value, b.unit));
  }
}

/// What was found, told as it is found.
class Findings {
 public:
  Findings(const runtime::Graph& graph, bool silent) : graph_(graph), silent_(silent) {}

  void compare(size_t index, const NodeResult& one, const NodeResult& other) {
    ++compared;
    std::vector<std::string> lines;
    for (const auto* result : {&one, &other})
      if (result->status == NodeStatus::failed && lines.empty()) lines.push_back(result->error);
    failed += !lines.empty();
    if (lines.empty() && is_good(one)) {
      for (const auto& [port, hashes] : one.outputs)
        if (const auto found = other.outputs.find(port); found == other.outputs.end() || found->second != hashes)
          lines.push_back("output " + port + " differs");
      if (is_good(other)) {
        compare_metrics(one.metrics, other.metrics, lines);
        if (one.warnings != other.warnings) lines.emplace_back("its warnings differ");
        if (one.messages != other.messages) lines.emplace_back("its messages differ");
      }
      if (!graph_.nodes[index].kind.node->deterministic && !lines.empty())
        lines.push_back("it says of itself that it is not deterministic");
      differing += !lines.empty();
    }
    if (!lines.empty())
      tell(runtime::label_of(graph_.nodes[index].name, one.round), graph_.nodes[index].kind.node->kind, lines);
  }

  void compare_rounds(const runtime::RoundsEnd& one, const runtime::RoundsEnd& other) {
    if (one.rounds != other.rounds) {
      ++differing;
      tell("rounds", "", {std::to_string(one.rounds) + " and " + std::to_string(other.rounds) + " of them"});
    }
    const std::string& problem = one.problem.empty() ? other.problem : one.problem;
    if (problem.empty()) return;
    ++failed;
    tell("rounds", "", {problem});
  }

  void tell(const std::string& name, const std::string& kind, const std::vector<std::string>& lines) {
    json.push_back({{"node", name}, {"kind", kind}, {"findings", lines}});
    if (silent_) return;
    std::printf("%s%s\n", name.c_str(), kind.empty() ? "" : (" (" + kind + ")").c_str());
    for (const std::string& line : lines) std::printf("  %s\n", runtime::printable(line).c_str());
  }

  /// The last line, and the exit code.
  int end(const std::string& how) const {
    const bool equal = differing == 0 && failed == 0;
    if (silent_)
      std::printf("%s\n", Json{{"equal", equal}, {"nodes", compared}, {"findings", json}}
                              .dump(1, ' ', false, Json::error_handler_t::replace)
                              .c_str());
    else
      std::printf("%s: %zu nodes, %s: %s\n", graph_.file.c_str(), compared, how.c_str(),
                  equal    ? "the same bits"
                  : failed ? "failed"
                           : (std::to_string(differing) + " differ").c_str());
    return equal ? 0 : 1;
  }

  size_t differing = 0, failed = 0, compared = 0;
  Json json = Json::array();

 private:
  const runtime::Graph& graph_;
  const bool silent_;
};

int verify_twice(const runtime::Graph& graph, const runtime::Registry& registry, const Options& options) {
  const OwnFolder folder;
  std::vector<runtime::RunResult> results;
  for (const int threads : {1, options.threads > 0 ? options.threads : 2}) {
    runtime::Store store(folder.path / std::to_string(threads));
    runtime::Observer silent;
    runtime::RunOptions run_options;
    run_options.threads = threads;
    results.push_back(execute(graph, registry, store, run_options, silent));
  }
  Findings findings(graph, options.json);
  for (size_t i = 0; i < std::min(results[0].earlier.size(), results[1].earlier.size()); ++i)
    findings.compare(results[0].earlier[i].node, results[0].earlier[i].result, results[1].earlier[i].result);
  for (size_t i = 0; i < graph.nodes.size(); ++i) findings.compare(i, results[0].nodes[i], results[1].nodes[i]);
  findings.compare_rounds(results[0].rounds, results[1].rounds);
  return findings.end("run twice");
}

/// A graph of one node, which is given what it was given.
runtime::Graph alone(const runtime::Graph& graph, size_t index, const NodeResult& result) {
  runtime::Graph one;
  one.file = graph.file;
  one.seed = graph.seed;
  one.nodes = {graph.nodes[index]};
  runtime::GraphNode& node = one.nodes[0];
  node.round = result.round;
  node.inputs.clear();
  node.given = result.inputs;
  return one;
}

/// What a node left behind in the process that computed a result cannot be seen by running the same process again.
int verify_each(const runtime::Graph& graph, const runtime::Registry& registry, const Options& options) {
  runtime::Store store = open_store(options);
  runtime::Observer silent;
  runtime::RunOptions run_options;
  run_options.threads = options.threads;
  const runtime::RunResult run = execute(graph, registry, store, run_options, silent);
  run_options.anew = run_options.isolate = true;
  run_options.remember = false;
  Findings findings(graph, options.json);
  const auto check = [&](size_t index, const NodeResult& result) {
    if (!is_good(result)) return findings.compare(index, result, result);
    findings.compare(index, result,
                     execute(alone(graph, index, result), registry, store, run_options, silent).nodes[0]);
  };
  for (const auto& earlier : run.earlier) check(earlier.node, earlier.result);
  for (size_t i = 0; i < graph.nodes.size(); ++i) check(i, run.nodes[i]);
  findings.compare_rounds(run.rounds, run.rounds);
  return findings.end("each run alone in a process of its own");
}

}  // namespace

int verify(const Options& options) {
  const runtime::Registry registry = discover();
  const runtime::Graph graph = load(options, registry);
  return options.each ? verify_each(graph, registry, options) : verify_twice(graph, registry, options);
}

}  // namespace plumbline::cli

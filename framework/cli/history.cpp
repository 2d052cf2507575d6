// plumbline why, diff, export: what runs did, from their records.
#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>

#include "commands.hpp"
#include "runtime/base/printable.hpp"
#include "runtime/record/run_record.hpp"
#include "runtime/run/executor.hpp"
#include "terminal.hpp"

namespace plumbline::cli {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

namespace {

void print_json(const Json& json) {
  std::printf("%s\n", json.dump(1, ' ', false, Json::error_handler_t::replace).c_str());
}

/// The run below out/ that began last, by what its record says: the time of a file is that of whoever copied it. Of two
/// that began at once the last by name.
runtime::RecordedRun newest_run() {
  std::optional<runtime::RecordedRun> newest;
  std::string unread;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator("out", error)) {
    const fs::path record = entry.path() / "run.jsonl";
    if (!fs::is_regular_file(record)) continue;
    try {
      runtime::RecordedRun run = runtime::read_run(record);
      const auto began = [](const runtime::RecordedRun& of) { return std::pair(of.start, of.file.string()); };
      if (!newest || began(run) > began(*newest)) newest = std::move(run);
    } catch (const std::runtime_error& why) {
      unread = why.what();
    }
  }
  if (!unread.empty()) std::fprintf(stderr, "warning: a record is not looked at: %s\n", unread.c_str());
  if (!newest) throw UsageError("there is no out/*/run.jsonl here; say which run: plumbline why NODE RUN");
  return *std::move(newest);
}

std::vector<std::string> reasons(const runtime::RecordedNode& node) {
  if (node.status == "reused") return {"nothing that its result depends on has changed"};
  if (node.status == "skipped") return {"'" + node.cause + "' failed"};
  if (node.status == "cancelled") return {"the run was cancelled"};
  std::vector<std::string> all = node.why;
  if (node.status == "failed") all.insert(all.begin(), node.error);
  return all;
}

}  // namespace

int why(const Options& options) {
  const runtime::RecordedRun run = options.runs.empty() ? newest_run() : runtime::read_run(options.runs[0]);
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
  for (const std::string& line : lines) std::printf("  %s\n", runtime::printable(line).c_str());
  return 0;
}

/// Nodes of two runs, those that both have once; a node of several rounds in each of them.
static size_t of_either(const runtime::RecordedRun& a, const runtime::RecordedRun& b) {
  return a.nodes.size() + static_cast<size_t>(std::count_if(b.nodes.begin(), b.nodes.end(), [&](const auto& node) {
           return !a.find(node.name, node.round);
         }));
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
    for (const std::string& line : difference.lines) std::printf("  %s\n", runtime::printable(line).c_str());
  }
  if (options.json)
    print_json({{"equal", equal}, {"nodes", json}});
  else
    std::printf("%zu of %zu nodes differ; the results %s\n", differences.size(), of_either(a, b),
                equal ? "agree" : "do not agree");
  return equal ? 0 : 1;
}

int export_run(const Options& options) {
  const runtime::RecordedRun run = runtime::read_run(options.runs.at(0));
  std::printf("%s", (options.format == "trace" ? chrome_trace(run) : ro_crate(run)).c_str());
  return 0;
}

}  // namespace plumbline::cli

#include "bench_summary.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>

#include "build_info.hpp"
#include "commands.hpp"
#include "runtime/base/new_file.hpp"
#include "runtime/record/deliver.hpp"
#include "runtime/record/record.hpp"

namespace plumbline::cli {

namespace fs = std::filesystem;
using runtime::SweepPlan;

runtime::BuildFacts build_facts() { return {PLUMBLINE_VERSION, build_commit(), build_compiler(), loaded_libraries()}; }

namespace {

/// The graph of the one node bench.summary, which makes the pages and tables of `cells`.
runtime::Graph summary_graph(const SweepPlan& plan, const runtime::Registry& registry, const fs::path& cells) {
  const runtime::Kind* kind = registry.find("bench.summary");
  if (!kind)
    throw std::runtime_error("there is no kind 'bench.summary': the plugin 'bench' is missing; see plumbline doctor");
  runtime::Graph graph;
  graph.file = plan.file.path.string();
  graph.sources = sources_of(plan);
  graph.sources.insert(graph.sources.begin(), {graph.file, plan.file.text});
  runtime::GraphNode node;
  node.name = "summary";
  node.kind = *kind;
  node.at = {graph.file, 0, 0};
  node.parameters["cells"] = cells.string();
  for (uint32_t i = 0; i < kind->node->output_count; ++i) {
    const std::string port = kind->node->outputs[i]->name;
    node.output_is_list[port] = false;
    graph.outputs.push_back({"bench." + port, {0, port, {}}});
  }
  graph.nodes.push_back(std::move(node));
  return graph;
}

/// Only one process at a time writes the table of a plan and reads it for its pages; a killed one holds nothing.
class TableLock {
 public:
  explicit TableLock(const fs::path& folder)
      : file_(::open((folder / "lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644)) {
    while (file_ >= 0 && flock(file_, LOCK_EX) != 0 && errno == EINTR) {
    }
  }
  TableLock(const TableLock&) = delete;
  TableLock& operator=(const TableLock&) = delete;
  ~TableLock() {
    if (file_ >= 0) ::close(file_);
  }

 private:
  int file_;
};

}  // namespace

SummaryWriter::SummaryWriter(const fs::path& out, const SweepPlan& plan, const runtime::Registry& registry,
                             runtime::Store& store, const BenchOptions& options)
    : plan_(plan),
      registry_(registry),
      store_(store),
      options_(options),
      cells_(store.folder() / "sweeps" / plan.id / "cells.json"),
      graph_(summary_graph(plan, registry, cells_)),
      folder_(out, store.file_hashes(), options.overwrite) {
  std::string text;
  for (const std::string& obstacle : obstacles_to(graph_, folder_)) text += "\n  " + obstacle;
  if (!text.empty())
    throw UsageError("nothing was run, because outputs would replace what this program did not write:" + text +
                     "\nChoose another folder with --out DIR, or replace them with --overwrite.");
}

bool SummaryWriter::write(size_t first_seeds) {
  const std::string table = sweep_table(plan_, runtime::CellRecords(store_), registry_, build_facts(), first_seeds);
  fs::create_directories(cells_.parent_path());
  const TableLock lock(cells_.parent_path());
  const fs::path fresh = cells_.parent_path() / ("cells-" + std::to_string(getpid()) + ".json");
  std::error_code ignored;
  fs::remove(fresh, ignored);
  runtime::write_new_file(fresh, table.data(), table.size());
  fs::rename(fresh, cells_);
  runtime::RunInfo info{PLUMBLINE_VERSION, options_.overrides, store_.folder(), 1, 0};
  runtime::Record record(folder_, graph_, info);
  runtime::Observer silent;
  runtime::RunOptions run;
  run.remember = false;
  const runtime::RunResult result = execute(graph_, registry_, store_, run, silent);
  record.node(graph_.nodes[0], result.nodes[0]);
  open_ = 1;
  for (const runtime::Metric& metric : result.nodes[0].metrics)
    if (metric.name == "open") open_ = metric.value;
  const auto deliveries = deliver(graph_, store_, result, folder_);
  record.end(result, deliveries);
  if (!result.ok()) std::fprintf(stderr, "%s\n", result.nodes[0].error.c_str());
  warnings_ = result.nodes[0].warnings;
  bool good = result.ok();
  for (const auto& delivery : deliveries) {
    if (delivery.problem.empty()) continue;
    good = false;
    std::fprintf(stderr, "%s: '%s' is not written: %s\n", graph_.file.c_str(), delivery.file.c_str(),
                 delivery.problem.c_str());
  }
  return good;
}

}  // namespace plumbline::cli

// What a node costs besides its own work: one graph, run by Plumbline (nothing stored, then all of it, then every node
// in a process of its own) and by a plain oneTBB flow graph that adds the same numbers and stores nothing. See
// README.md.
//
//   runtime_benchmark FOLDER [NODES]        FOLDER: where the stores go; /dev/shm for a tmpfs
#include <oneapi/tbb/flow_graph.h>
#include <oneapi/tbb/global_control.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>

#include "runtime/record/output_folder.hpp"
#include "runtime/record/record.hpp"
#include "runtime/run/executor.hpp"

namespace {

namespace fs = std::filesystem;
namespace flow = oneapi::tbb::flow;
using namespace plumbline::runtime;

double now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

/// A record is part of a run, and costs what it costs.
class Recorder : public Observer {
 public:
  explicit Recorder(Record& record) : record_(record) {}
  void node_finished(const GraphNode& node, const NodeResult& result) override { record_.node(node, result); }

 private:
  Record& record_;
};

/// A row of additions, or as many side by side.
std::string pipeline(int nodes, bool chain) {
  std::string text =
      "plumbline: 1\nvars: {seed: 1, value: 0}\nnodes:\n  n0: {use: story.constant, with: {value: \"${value}\"}}\n";
  for (int i = 1; i < nodes; ++i)
    text += "  n" + std::to_string(i) + ": {use: story.add, in: {a: n" +
            (chain && i > 1 ? std::to_string(i - 1) + ".sum" : std::string("0.number")) +
            "}, with: {offset: " + std::to_string(i) + "}}\n";
  return text;
}

struct Times {
  double link = 0, executed = 1e9, reused = 1e9, isolated = 1e9;  // seconds
};

/// One run, from the opening of the output folder to the end of the record.
double run_seconds(const fs::path& folder, const fs::path& store_folder, const Graph& graph, const Registry& registry,
                   const RunOptions& options, NodeStatus expected) {
  Store store(store_folder);
  OutputFolder out(folder / "out", store.file_hashes());
  const double start = now();
  Record record(out, graph, {});
  Recorder recorder(record);
  const RunResult result = execute(graph, registry, store, options, recorder);
  record.end(result, {});
  const double seconds = now() - start;
  if (result.count(expected) != graph.nodes.size()) throw std::runtime_error("not all nodes did what they should");
  return seconds;
}

Times plumbline_times(const fs::path& folder, int nodes, bool chain, int threads) {
  const fs::path file = folder / "p.yaml";
  std::ofstream(file) << pipeline(nodes, chain);
  Registry registry;
  if (!registry.load(PLUMBLINE_STORY_PLUGIN)) throw std::runtime_error(registry.refused().at(0).problem);
  Times times;
  double start = now();
  const Graph graph = load_pipeline(file, {}, registry);
  times.link = now() - start;
  for (int repeat = 0; repeat < 5; ++repeat) {
    const fs::path store = folder / ("store" + std::to_string(repeat)), other = folder / "other";
    RunOptions options;
    options.threads = threads;
    options.worker = PLUMBLINE_WORKER;
    const auto run = [&](double& best, const fs::path& store_folder, NodeStatus expected) {
      best = std::min(best, run_seconds(folder, store_folder, graph, registry, options, expected));
    };
    run(times.executed, store, NodeStatus::executed);
    run(times.reused, store, NodeStatus::reused);
    options.isolate = true;
    run(times.isolated, other, NodeStatus::executed);
    fs::remove_all(store);
    fs::remove_all(other);
  }
  return times;
}

double tbb_seconds(int nodes, bool chain, int threads) {
  const oneapi::tbb::global_control limit(oneapi::tbb::global_control::max_allowed_parallelism, threads);
  using Node = flow::continue_node<flow::continue_msg>;
  double best = 1e9;
  for (int repeat = 0; repeat < 5; ++repeat) {
    std::vector<double> values(nodes);
    const double start = now();
    flow::graph graph;
    std::vector<std::unique_ptr<Node>> all;
    for (int i = 0; i < nodes; ++i) {
      const int before = chain ? i - 1 : 0;
      all.push_back(std::make_unique<Node>(graph, [&values, i, before](flow::continue_msg) {
        values[i] = i == 0 ? 1 : values[before] + i;
        return flow::continue_msg();
      }));
      if (i > 0) flow::make_edge(*all[before], *all[i]);
    }
    all[0]->try_put(flow::continue_msg());
    graph.wait_for_all();
    best = std::min(best, now() - start);
  }
  return best;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr, "runtime_benchmark FOLDER [NODES]\n");
    return 2;
  }
  const int nodes = argc > 2 ? std::atoi(argv[2]) : 1000;
  const fs::path folder = fs::path(argv[1]) / ("plumbline-benchmark-" + std::to_string(getpid()));
  fs::create_directories(folder);
  std::printf("%d nodes in %s, microseconds a node (best of 5)\n", nodes, argv[1]);
  std::printf("%-7s %-8s %10s %10s %10s %10s %10s\n", "graph", "threads", "link", "executed", "isolated", "reused",
              "oneTBB");
  for (const bool chain : {true, false})
    for (const int threads : {1, 2}) {
      const Times times = plumbline_times(folder, nodes, chain, threads);
      const double each = 1e6 / nodes;
      std::printf("%-7s %-8d %10.1f %10.1f %10.1f %10.1f %10.2f\n", chain ? "chain" : "wide", threads,
                  times.link * each, times.executed * each, times.isolated * each, times.reused * each,
                  tbb_seconds(nodes, chain, threads) * each);
    }
  fs::remove_all(folder);
  return 0;
}

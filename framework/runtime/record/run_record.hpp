// A run record read back: what `plumbline why`, `diff`, `export` and `replay` work on. record.hpp has its lines.
#pragma once

#include <filesystem>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "runtime/graph/graph.hpp"
#include "runtime/run/key.hpp"
#include "runtime/store/store.hpp"

namespace plumbline::runtime {

/// There is no record at the place that was named.
struct NoRunRecord : std::runtime_error {
  using std::runtime_error::runtime_error;
};

struct RecordedNode {
  std::string name, kind, status, error, cause;
  size_t round = 0;               ///< of a pipeline with rounds; 0: not one of them
  double start = 0, seconds = 0;  ///< start: seconds since 1970
  struct Computed {
    std::string first, last;  ///< UTC; empty: not known
    double seconds = 0;
    std::vector<std::string> hosts, threads, programs, plugins;
    size_t unknown = 0;  ///< items of which it is not known
  } computed;            ///< by this run or an earlier one
  size_t items = 0, items_executed = 0;
  std::string plugin, plugin_version, plugin_sha256;
  KeyFields fields;
  std::vector<std::string> why, keys;
  std::map<std::string, std::string> connections;  ///< input port -> "node.port"
  std::map<std::string, Hashes> inputs, outputs;
  std::map<std::string, std::string> types;  ///< of the outputs
  std::vector<Metric> metrics;
};

struct RecordedRun {
  std::filesystem::path file;
  std::string version, time, end_time, host, pipeline, folder, store, status;
  std::vector<std::string> arguments;
  std::map<std::string, std::string> variables;
  std::vector<SourceFile> sources;
  bool usable = true;  ///< false: it ended with exit code 3
  double start = 0, seconds = 0;
  std::vector<RecordedNode> nodes;               ///< in the order they ended
  std::map<std::string, std::string> delivered;  ///< file that this run wrote, or found as it must be -> SHA-256
  /// By name; of a node that ran in several rounds the last, or that of "name@3".
  const RecordedNode* find(const std::string& name) const;
  const RecordedNode* find(const std::string& name, size_t round) const;
};

/// `path` is a run.jsonl or the folder of one. Throws std::runtime_error if it cannot be read or is no record.
/// Throws NoRunRecord if there is none.
RecordedRun read_run(const std::filesystem::path& path);

/// Differences of two runs, node by node.
struct NodeDifference {
  std::string node;
  std::vector<std::string> lines;  ///< what differs, one line each
  bool within_tolerance = true;    ///< only numbers differ, by less than the tolerance
};

/// `tolerance` of two numbers is a share of the larger one where that is below 1, and their difference itself above (of
/// coordinates in m: metres). Outputs that differ are compared number by number if `store`
/// has both and a plugin knows their type. Nodes that do not differ are left out; the others stand in the order of what
/// depends on what, the cause before what follows from it.
std::vector<NodeDifference> compare_runs(const RecordedRun& a, const RecordedRun& b, double tolerance, Store* store,
                                         const Registry& registry);

/// For chrome://tracing and Perfetto: one lane for each node that ran beside others.
std::string chrome_trace(const RecordedRun& run);

/// ro-crate-metadata.json, RO-Crate 1.1 with a CreateAction for each node, for the folder of the record.
std::string ro_crate(const RecordedRun& run);

}  // namespace plumbline::runtime

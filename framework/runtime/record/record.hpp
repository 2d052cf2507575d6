// The run record: run.jsonl in the output folder, one JSON object a line, in the order of events.
//
//   {"event": "run_start", "plumbline", "time", "start", "host", "cpu_flags", "pipeline", "pipeline_sha256", "folder",
//    "sources", "arguments", "variables", "seed", "store", "threads", "memory_limit", "plugins",
//    "process", "staging", "owned"}
//   {"event": "node", "name", "kind", "round", "at", "status", "items", "items_executed", "start", "seconds",
//    "item_seconds", "computed", "memory", "plugin", "parameters", "connections", "fields", "why", "used", "inputs",
//    "outputs", "types", "keys", "metrics", "warnings", "messages", "error", "failure", "cause"}    one for each node,
//    as it ends
//   {"event": "round", "round", "over", "finished", "condition", "error"}   after each round of a pipeline with rounds
//   {"event": "deliver", "output", "number", "files", "folders"}      before an output is put in place
//   {"event": "killed", "by"}                                         in place of run_end: a node ended the program
//   {"event": "run_end", "status", "usable", "executed", "reused", "failed", "skipped", "seconds", "peak_memory",
//    "rounds", "outputs", "owned"}
//
// "usable" of a run whose status is ok: false where it ends with exit code 3, because a node says so or its rounds did
// not come to their end.
//
// "sources" are the texts of the pipeline and of all it includes, "arguments" the overrides, "folder" the working
// folder: with the plugins of "plugin" (and the build ids of the libraries they are linked with) they make the run
// again. "fields" is what the node's key was made of, "why" what of it changed since the pipeline's last run, "used"
// the files that it was found to depend on beside. "memory" has what the node announced, what it took if it ran in a
// process of its own, and the most that the program's process had used when it ended.
//
// "seconds" of a node is the time on the clock from the start of its first item to the end of its last; "item_seconds"
// is the sum over its items, which is more where they ran side by side. "computed" says of executed and reused results
// alike when ("first" and "last" of its items), where, on how many threads and by which versions they were computed,
// and how many seconds that took; its "unknown_items" are those, of results of older
// programs, of which none of it is known. "cause" names the failed node that made a node skip. "staging", "owned" and
// the deliver lines prove which files in the folder the program wrote (ownership.hpp); no run replaces or removes
// others. Wall times are here and in the store's records, nowhere else: artifacts hold none.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "runtime/record/deliver.hpp"
#include "runtime/run/executor.hpp"

namespace plumbline::runtime {

/// Of the system since it was started; the number of a process means something until then. Empty: not known.
std::string boot_id();

struct RunInfo {
  std::string version;                 ///< of the program
  std::vector<std::string> arguments;  ///< the KEY=VALUE overrides
  std::filesystem::path store;
  int threads = 0;
  uint64_t memory = 0;  ///< limit in bytes
};

class Record {
 public:
  /// Starts run.jsonl in `out`, which must outlive the record as must the graph. Throws std::runtime_error if it cannot
  /// be written.
  Record(OutputFolder& out, const Graph& graph, const RunInfo& info);
  ~Record();
  Record(const Record&) = delete;
  Record& operator=(const Record&) = delete;
  void node(const GraphNode& node, const NodeResult& result);
  void round(const RoundsEnd& end);
  void end(const RunResult& result, const std::vector<Delivery>& deliveries);

  /// The line of a node as JSON text, without its end of line.
  static std::string node_line(const GraphNode& node, const NodeResult& result, bool with_connections = false);

 private:
  OutputFolder& out_;
  const Graph& graph_;
  double start_ = 0;
};

}  // namespace plumbline::runtime

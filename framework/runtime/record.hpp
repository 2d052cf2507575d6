// The run record: run.jsonl in the output folder, one JSON object a line, in the order of events.
//
//   {"event": "run_start", "plumbline", "host", "cpu_flags", "pipeline", "pipeline_sha256", "variables", "seed",
//   "store", "staging", "owned", ...}
//   {"event": "node", "name", "kind", "status", "items", "items_executed", "seconds",
//    "item_seconds", "plugin", "parameters", "inputs",
//    "outputs", "keys", "metrics", "warnings", "messages", "error",
//    "cause"}                              one for each node, as
//    it ends
//   {"event": "deliver", "output", "number", "files", "folders"}      before an output is put in place
//   {"event": "run_end", "status", "executed", "reused", "failed", "skipped", "seconds", "peak_memory", "outputs",
//    "owned"}
//
// "seconds" of a node is the time on the clock from the start of its first item to the end of its last; "item_seconds"
// is the sum over its items, which is more where they ran side by side. "cause" names the failed node that made a node
// skip. "staging", "owned" and the deliver lines prove which files in the folder the program wrote (ownership.hpp); no
// run replaces or removes others. Wall times are here and nowhere else: artifacts hold none.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "runtime/deliver.hpp"
#include "runtime/executor.hpp"

namespace plumbline::runtime {

struct RunInfo {
  std::string version;                 ///< of the program
  std::vector<std::string> arguments;  ///< the KEY=VALUE overrides
  std::filesystem::path store;
  int threads = 0;
  uint64_t memory = 0;  ///< limit in bytes
};

class Record {
 public:
  /// Starts run.jsonl in `out`, which must outlive the record. Throws std::runtime_error if it cannot be written.
  Record(OutputFolder& out, const Graph& graph, const RunInfo& info);
  void node(const GraphNode& node, const NodeResult& result);
  void end(const RunResult& result, const std::vector<Delivery>& deliveries);

  /// The line of a node as JSON text, without its end of line.
  static std::string node_line(const GraphNode& node, const NodeResult& result);

 private:
  OutputFolder& out_;
  double start_ = 0;
};

}  // namespace plumbline::runtime

// One run of a node on one item: the services of plugin.h, and what came out.
#pragma once

#include <atomic>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "runtime/base/memory_budget.hpp"
#include "runtime/graph/graph.hpp"
#include "runtime/run/key.hpp"
#include "runtime/run/workers.hpp"
#include "runtime/store/store.hpp"

namespace plumbline::runtime {

struct NodeCall {
  const GraphNode* node = nullptr;
  const Registry* registry = nullptr;
  std::map<std::string, Hashes> inputs;  ///< by connected port; the EACH port holds one item
  std::string key;                       ///< without the seed
  uint64_t seed = 0;
};

/// What all runs of a program share.
struct NodeServices {
  Store* store = nullptr;
  MemoryBudget* memory = nullptr;
  const std::atomic<bool>* cancel = nullptr;
  std::function<void(double fraction, const std::string& text)> progress;  ///< may be empty
  std::function<void()> seed_drawn;                                        ///< at the first time; may be empty
  Workers* workers = nullptr;  ///< where the node runs; null: in this process
};

struct NodeOutcome {
  std::string error;                            ///< empty: all went well, and `run` is complete
  plumbline_answer failure = PLUMBLINE_FAILED;  ///< of what kind the error is
  bool cancelled = false;  ///< it was told to stop: what it gave may be half of it, and must not be stored
  uint64_t memory_announced = 0, memory_taken = 0;  ///< in bytes; taken: 0 if it is not known, as in this process
  std::string excess;      ///< that it took more than the limit, in words; of this machine, so it is not stored
  bool drew_seed = false;  ///< then the result belongs to the key with the seed
  StoredRun run;
};

/// Runs the node in this thread. Never throws for what the node does; what it committed is in the store, what it wrote
/// to folders is renamed into place only if it succeeded.
NodeOutcome run_node(const NodeCall& call, const NodeServices& services);

}  // namespace plumbline::runtime

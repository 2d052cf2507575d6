// Runs a linked graph: branches and items in parallel on oneTBB, what is in the store already taken from there.
//
// A node starts when the nodes it takes from are done. Each run of a node is inside this_task_arena::isolate: a thread
// that waits in a node's own parallel loop must not start another node on its stack. A node that fails ends its branch:
// what follows is skipped, the other branches go on. Results are joined in the items' order, so they do not depend on
// the number of threads. What another thread or process computes already is waited for and taken over (claims.hpp).
#pragma once

#include <atomic>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "runtime/graph/graph.hpp"
#include "runtime/run/key.hpp"
#include "runtime/store/store.hpp"

namespace plumbline::runtime {

enum class NodeStatus { executed, reused, failed, skipped, cancelled };
const char* to_text(NodeStatus status);
/// "failed", "bad_input" or "not_converged".
const char* to_text(plumbline_answer failure);

struct NodeResult {
  NodeStatus status = NodeStatus::cancelled;
  size_t round = 0;                               ///< GraphNode::round
  std::string error;                              ///< why it failed or was skipped
  plumbline_answer failure = PLUMBLINE_DONE;      ///< of a failed node: of what kind; of several items the plainest
  std::string cause;                              ///< of a skipped node: the node whose failure began it
  size_t items = 0;                               ///< how often it had to run: 1, or the number of items
  size_t items_executed = 0;                      ///< of those, how many were not in the store
  KeyFields fields;                               ///< what its key is made of; over all items for a node that maps
  Hashes keys;                                    ///< of each item, under which the store has its run
  std::map<std::string, Hashes> inputs, outputs;  ///< blobs by port
  std::vector<Metric> metrics;
  std::vector<std::string> warnings, messages;
  std::map<std::string, std::string> used;  ///< hash by path of files found to be used, StoredRun::used of all items
  std::vector<std::string> why;  ///< of one that was executed: what of its key changed since the pipeline's last run
  /// Where and when its items were computed, now or by earlier runs; of results of older programs it is not known.
  struct Computed {
    double first = 0, last = 0;  ///< seconds since 1970: the first of them began, the last began
    double seconds = 0;          ///< sum over the items, then
    std::set<std::string> hosts, programs, plugins;
    std::set<int> threads;
    size_t unknown = 0;  ///< items of which none of this is known
  } computed;
  double start = 0;               ///< seconds since 1970 at which the first item that ran now began; 0 if none did
  uint64_t memory_announced = 0;  ///< the most that one item asked for, in bytes
  uint64_t memory_taken = 0;      ///< the most that one item took, in bytes; known of a run in a worker only
  double seconds = 0;       ///< from the start of the first item that ran now to the end of the last; 0 if none ran
  double item_seconds = 0;  ///< sum over those items; more than `seconds` where they ran side by side
};

bool is_good(const NodeResult& result);  ///< executed or reused

/// How the rounds of a graph stand after one of them.
struct RoundsEnd {
  size_t rounds = 0;      ///< how many there were
  bool over = false;      ///< there is no other
  bool finished = false;  ///< because the condition of the pipeline holds; not because of the bound
  std::string text;       ///< "update.changed = 0 holds (0)"
  std::string problem;    ///< the condition cannot be judged
};

struct RunResult {
  std::vector<NodeResult> nodes;  ///< as Graph::nodes; of one that ran in several rounds the last
  struct EarlierRound {
    size_t node = 0, round = 0;
    NodeResult result;
  };
  std::vector<EarlierRound> earlier;  ///< of nodes that ran in several rounds, all but the last
  RoundsEnd rounds;                   ///< of a pipeline with rounds
  bool cancelled = false;
  bool ok() const;
  /// ok(), no node says that its result must not be used (metric `invalid`), and rounds, if there are any, came to
  /// their end by their condition.
  bool usable() const;
  /// Whether all that failed did so because a solver found no result.
  bool not_converged() const;
  size_t count(NodeStatus status) const;  ///< of all rounds
};

/// Watches a run. Calls come from several threads, never two at once.
class Observer {
 public:
  virtual ~Observer() = default;
  virtual void node_started(const GraphNode&, size_t /*items*/) {}
  virtual void node_progress(const GraphNode&, size_t /*items_done*/, size_t /*items*/, double /*fraction*/,
                             const std::string& /*text*/) {}
  virtual void node_finished(const GraphNode&, const NodeResult&) {}
  virtual void round_finished(const RoundsEnd&) {}
};

struct RunOptions {
  int threads = 0;      ///< 0: as many as the machine has
  uint64_t memory = 0;  ///< bytes that nodes may reserve together; 0: MemoryBudget::default_limit()
  const std::atomic<bool>* cancel = nullptr;  ///< set it to end the run early
  bool remember = true;  ///< at the end, keys for `plumbline plan`, and sync; a sweep of many graphs does without
  bool isolate = false;  ///< every node in a process of its own, not only those that ask for it
  /// Everything runs and nothing is taken from the store. The outputs are there as long as they are blobs of it, which
  /// hands them from node to node; no record names them as a result that another run would take.
  bool anew = false;
  std::filesystem::path worker = {};  ///< the program for that, if it is not where it is installed
  bool keep_memory = false;  ///< a node that alone reserves more fails; otherwise it runs alone, with a warning
};

/// Never throws for what a node does. At the end the store remembers the keys for `plumbline plan`.
RunResult execute(const Graph& graph, const Registry& registry, Store& store, const RunOptions& options,
                  Observer& observer);

/// Inputs of a node by connected port, from the outputs of the nodes before it.
std::map<std::string, Hashes> inputs_of(const GraphNode& node,
                                        const std::vector<std::map<std::string, Hashes>>& outputs_of_nodes);

/// Of these, what its run on one item gets: of the EACH port that item, of the others all.
std::map<std::string, Hashes> inputs_of_item(const GraphNode& node, const std::map<std::string, Hashes>& inputs,
                                             size_t item);

/// Identifies the pipeline whose last keys the store remembers: its absolute path.
std::string pipeline_id(const Graph& graph);
/// Key fields by node of the last run of the pipeline; empty if the store knows of none.
std::map<std::string, KeyFields> last_keys(const Store& store, const Graph& graph);

}  // namespace plumbline::runtime

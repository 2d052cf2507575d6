#include "runtime/run/graph_run.hpp"

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/task_arena.h>
#include <oneapi/tbb/task_group.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <mutex>
#include <thread>

#include "runtime/run/node_run.hpp"
#include "runtime/run/watched_run.hpp"
#include "runtime/store/used_files.hpp"

namespace plumbline::runtime {

namespace {

/// One run of a node on one item.
struct Item {
  StoredRun run;
  std::string key, error, outdated;
  plumbline_answer failure = PLUMBLINE_FAILED;
  bool executed = false, cancelled = false, drew_seed = false;
  uint64_t memory_announced = 0, memory_taken = 0;
  std::chrono::steady_clock::time_point begin, end;  // of the node's run, if it ran
  std::vector<std::string> warnings;
};

/// The steady clock has no date; its distance from the one that has is taken now.
double since_1970(std::chrono::steady_clock::time_point time) {
  using Seconds = std::chrono::duration<double>;
  const double ago = Seconds(std::chrono::steady_clock::now() - time).count();
  return Seconds(std::chrono::system_clock::now().time_since_epoch()).count() - ago;
}

void add_times(const std::vector<Item>& items, NodeResult& result) {
  using Seconds = std::chrono::duration<double>;
  auto begin = std::chrono::steady_clock::time_point::max(), end = std::chrono::steady_clock::time_point::min();
  for (const Item& item : items) {
    if (!item.executed) continue;
    begin = std::min(begin, item.begin), end = std::max(end, item.end);
    result.item_seconds += Seconds(item.end - item.begin).count();
    result.memory_announced = std::max(result.memory_announced, item.memory_announced);
    result.memory_taken = std::max(result.memory_taken, item.memory_taken);
  }
  if (begin >= end) return;
  result.seconds = Seconds(end - begin).count();
  result.start = since_1970(begin);
}

void add_provenance(const StoredRun& run, NodeResult::Computed& computed) {
  const Provenance& from = run.provenance;
  if (from.start <= 0) return;
  computed.first = computed.first > 0 ? std::min(computed.first, from.start) : from.start;
  computed.last = std::max(computed.last, from.start);
  computed.seconds += run.seconds;
  computed.hosts.insert(from.host);
  computed.threads.insert(from.threads);
  computed.programs.insert(from.program);
  computed.plugins.insert(from.plugin);
}

std::string name_of_host() {
  char host[65] = "host";
  gethostname(host, sizeof host - 1);
  return host;
}

class Execution {
 public:
  Execution(const Graph& graph, const Registry& registry, Store& store, const RunOptions& options, Observer& observer)
      : graph_(graph),
        registry_(registry),
        store_(store),
        observer_(observer),
        memory_(options.memory, options.keep_memory),
        threads_(options.threads > 0 ? options.threads : static_cast<int>(std::thread::hardware_concurrency())),
        cancel_(options.cancel ? *options.cancel : never_),
        isolate_all_(options.isolate),
        workers_(options.worker, threads_),
        runs_(workers_),
        remember_(options.remember),
        anew_(options.anew),
        states_(graph.nodes.size()),
        outputs_(graph.nodes.size()) {
    for (size_t i = 0; i < graph.nodes.size(); ++i) {
      for (const auto& [port, source] : graph.nodes[i].inputs) {
        states_[source.node].followers.push_back(i);
        ++states_[i].waiting;
      }
    }
  }

  RunResult run() {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<size_t>(threads_));
    tbb::task_arena arena(threads_);
    arena.execute([&] {
      for (size_t i = 0; i < states_.size(); ++i)
        if (graph_.nodes[i].inputs.empty()) group_.run([this, i] { start(i); });
      group_.wait();
    });
    RunResult result;
    for (State& state : states_) result.nodes.push_back(std::move(state.result));
    result.cancelled = result.count(NodeStatus::cancelled) > 0;
    return result;
  }

 private:
  struct State {
    std::atomic<size_t> waiting = 0;  // connections whose source is not done
    std::vector<size_t> followers;    // once for each connection
    std::vector<Item> items;
    std::atomic<size_t> items_left = 0;
    KeyFields fields;  // without inputs
    NodeResult result;
  };

  void start(size_t index) {
    const GraphNode& node = graph_.nodes[index];
    State& state = states_[index];
    NodeResult& result = state.result;
    result.round = node.round;
    if (cancel_) return finish(index, NodeStatus::cancelled, "");
    for (const auto& [port, source] : node.inputs) {
      const NodeStatus before = states_[source.node].result.status;
      if (before == NodeStatus::executed || before == NodeStatus::reused) continue;
      const std::string& name = graph_.nodes[source.node].name;
      result.cause = before == NodeStatus::failed ? name : states_[source.node].result.cause;
      return finish(index, before == NodeStatus::cancelled ? NodeStatus::cancelled : NodeStatus::skipped,
                    "its input '" + port + "' comes from '" + name + "', which " +
                        (before == NodeStatus::failed      ? "failed"
                         : before == NodeStatus::cancelled ? "did not run"
                                                           : "did not run because '" + result.cause + "' failed"));
    }
    try {
      result.inputs = inputs_of(node, outputs_);
      state.fields = key_fields(node, store_.file_hashes());
    } catch (const std::exception& error) {
      return finish(index, NodeStatus::failed, error_text(node, "", error.what()));
    }
    result.fields = state.fields;
    add_inputs(result.fields, result.inputs);
    result.items = node.maps ? result.inputs.at(node.each_port).size() : 1;
    state.items.resize(result.items);
    state.items_left = result.items;
    observe([&] { observer_.node_started(node, result.items); });
    if (result.items == 0) return finish_items(index);
    // The last one first: a thread takes up its own newest task, so the items run in their order.
    for (size_t item = result.items; item-- > 1;) group_.run([this, index, item] { run_item(index, item); });
    run_item(index, 0);
  }

  void run_item(size_t index, size_t number) {
    const GraphNode& node = graph_.nodes[index];
    State& state = states_[index];
    Item& item = state.items[number];
    try {
      if (cancel_)
        item.cancelled = true;
      else
        compute(node, state, number, item);
    } catch (const std::exception& error) {  // the store's: disk full, no rights
      item.error = error.what();
    }
    const size_t left = --state.items_left;
    if (state.items.size() > 1)
      observe([&] { observer_.node_progress(node, state.items.size() - left, state.items.size(), 0, ""); });
    if (left == 0) finish_items(index);
  }

  /// Takes the item's result from the store or runs the node on it.
  void compute(const GraphNode& node, const State& state, size_t number, Item& item) {
    NodeCall call;
    call.node = &node;
    call.registry = &registry_;
    call.inputs = inputs_of_item(node, state.result.inputs, number);
    KeyFields fields = state.fields;
    add_inputs(fields, call.inputs);
    call.key = key_of(fields);
    call.seed = seed_of(graph_.seed, node.name, number, node.round);
    const bool reusable = node.kind.node->deterministic && !anew_;
    if (reusable) {
      Stored stored = look_up(store_, call.key, call.seed);
      if (!stored.key.empty()) {
        item.drew_seed = stored.key != call.key;
        item.key = stored.key;
        item.run = std::move(stored.run);
        return;
      }
      item.outdated = stored.outdated;
      if (!stored.damage.empty()) item.warnings.push_back("its stored result cannot be used: " + stored.damage);
    }
    Turn turn(store_.claims(), call.key, key_with_seed(call.key, call.seed));
    if (reusable && !wait_for_turn(node, state, call, turn, item)) return;
    NodeServices services{&store_,
                          &memory_,
                          &cancel_,
                          {},
                          [&turn] { turn.seed_was_drawn(); },
                          isolate_all_ || node.isolate ? &workers_ : nullptr};
    if (state.items.size() == 1)
      services.progress = [&](double fraction, const std::string& text) {
        observe([&] { observer_.node_progress(node, 0, 1, fraction, text); });
      };
    item.begin = std::chrono::steady_clock::now();
    NodeOutcome outcome = runs_.run(call, services);
    item.end = std::chrono::steady_clock::now();
    item.executed = true;
    item.cancelled = outcome.cancelled;
    item.error = outcome.error;
    item.failure = outcome.failure;
    item.drew_seed = outcome.drew_seed;
    item.memory_announced = outcome.memory_announced, item.memory_taken = outcome.memory_taken;
    if (!outcome.excess.empty()) item.warnings.push_back(outcome.excess);
    item.key = outcome.drew_seed ? key_with_seed(call.key, call.seed) : call.key;
    item.run = std::move(outcome.run);
    item.run.provenance = {since_1970(item.begin), host_, threads_, PLUMBLINE_VERSION,
                           node.kind.plugin->identity.version};
    if (!item.error.empty() || item.cancelled) return;
    check_files(node, state);
    if (cancel_) {
      item.cancelled = true;
      return;
    }
    if (anew_) return;
    if (!node.kind.node->deterministic) return store_.keep(item.run);
    store_.put_run(item.key, item.run);
    turn.done();
  }

  /// What parameters name must be after the run what it was when the key was made.
  void check_files(const GraphNode& node, const State& state) {
    bool names_files = false;
    for (uint32_t i = 0; i < node.kind.node->param_count; ++i)
      names_files |=
          node.kind.node->params[i]->kind == PLUMBLINE_FILE || node.kind.node->params[i]->kind == PLUMBLINE_FOLDER;
    if (!names_files) return;
    for (const auto& [field, value] : key_fields(node, store_.file_hashes()))
      if (state.fields.at(field) != value)
        throw std::runtime_error(field + " changed while the node worked with it; run again");
  }

  /// Waits as long as somebody else computes the same, and takes over what came of it. False: there is nothing to
  /// compute any more.
  bool wait_for_turn(const GraphNode& node, const State& state, const NodeCall& call, Turn& turn, Item& item) {
    bool waited = false, was_done = false;
    const auto since = std::chrono::steady_clock::now();
    for (int pause = 1; !turn.take(); pause = std::min(2 * pause, 50)) {
      if (cancel_) {
        item.cancelled = true;
        return false;
      }
      if (store_.claims().holder_is_stopped(turn.busy())) return true;
      const std::string holder = store_.claims().holder(turn.busy());
      if (waited && state.items.size() == 1 && std::chrono::steady_clock::now() - since > std::chrono::seconds(1))
        observe(
            [&] { observer_.node_progress(node, 0, 1, 0, "waits for " + (holder.empty() ? "another run" : holder)); });
      waited = true;
      store_.claims().wait(pause);
    }
    // Since it was looked for, somebody may have come and gone: then the claim says so, which is quicker to read than
    // two files that are not there.
    was_done = turn.was_done();
    // A shared folder may show a file some seconds after the other machine has written it.
    for (int attempt = 0; waited || was_done; ++attempt) {
      Stored stored = look_up(store_, call.key, call.seed);
      if (!stored.key.empty()) {
        item.drew_seed = stored.key != call.key;
        item.key = stored.key;
        item.run = std::move(stored.run);
        item.warnings.clear();
        return false;
      }
      if (!(waited && was_done) || attempt == 100 || cancel_) break;
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    turn.begin();
    return true;
  }

  static std::string error_text(const GraphNode& node, const std::string& where, const std::string& what) {
    return node.at.text() + ": node '" + node.name + "' (" + node.kind.node->kind + ") failed" + where + ": " + what;
  }

  /// Joins the items' results in their order.
  void finish_items(size_t index) {
    const GraphNode& node = graph_.nodes[index];
    State& state = states_[index];
    NodeResult& result = state.result;
    for (uint32_t i = 0; i < node.kind.node->output_count; ++i) result.outputs[node.kind.node->outputs[i]->name];
    std::string errors;
    std::map<std::string, size_t> failures;  // a file that all items read is wrong for all of them
    for (const Item& item : state.items) ++failures[item.error];
    bool cancelled = false, drew_seed = false;
    for (size_t number = 0; number < state.items.size(); ++number) {
      Item& item = state.items[number];
      const std::string where =
          node.maps ? " on item " + std::to_string(number + 1) + " of " + std::to_string(result.items) : "";
      for (auto& [port, hashes] : item.run.outputs)
        result.outputs[port].insert(result.outputs[port].end(), hashes.begin(), hashes.end());
      for (Metric& metric : item.run.metrics) result.metrics.push_back(std::move(metric));
      for (const auto* warnings : {&item.warnings, &item.run.warnings})
        for (const std::string& text : *warnings) result.warnings.push_back(node.maps ? text + where : text);
      for (const std::string& text : item.run.messages) result.messages.push_back(node.maps ? text + where : text);
      result.items_executed += item.executed;
      result.keys.push_back(item.key);
      cancelled |= item.cancelled;
      drew_seed |= item.drew_seed;
      if (item.executed && !item.outdated.empty()) result.why.push_back(item.outdated + (node.maps ? where : ""));
      for (const auto& [file, hash] : item.run.used)
        if (hash != absent_hash) result.used.emplace(file, hash);
      add_provenance(item.run, result.computed);
      if (item.run.provenance.start <= 0 && item.error.empty() && !item.cancelled) ++result.computed.unknown;
      size_t& alike = failures[item.error];
      if (!item.error.empty() && !item.cancelled)
        result.failure =
            result.failure == PLUMBLINE_DONE || result.failure == item.failure ? item.failure : PLUMBLINE_FAILED;
      if (!item.error.empty() && !item.cancelled && alike > 0) {
        const std::string others = alike > 1 ? " (and " + std::to_string(alike - 1) + " others alike)" : "";
        errors += (errors.empty() ? "" : "\n") + error_text(node, where + others, item.error);
        alike = 0;
      }
    }
    add_times(state.items, result);
    if (drew_seed) result.fields["seed"] = std::to_string(graph_.seed);
    if (result.items_executed > 0) explain(node, result);
    state.items.clear();
    state.items.shrink_to_fit();
    if (!errors.empty()) return finish(index, NodeStatus::failed, errors);
    if (cancelled) return finish(index, NodeStatus::cancelled, "");
    outputs_[index] = result.outputs;
    finish(index, result.items_executed > 0 ? NodeStatus::executed : NodeStatus::reused, "");
  }

  void explain(const GraphNode& node, NodeResult& result) {
    // Read only now: where all is reused nobody asks for it.
    std::call_once(last_read_, [&] {
      if (remember_) last_ = last_keys(store_, graph_);
    });
    const auto before = last_.find(label_of(node));
    if (!node.kind.node->deterministic)
      result.why = {"it is not deterministic and always runs"};
    else if (!result.why.empty())
      return;  // told already: files that it used
    else if (before == last_.end())
      result.why = {"it never ran in this pipeline before"};
    else
      result.why = compare(before->second, result.fields);
    if (result.why.empty()) result.why = {"its result was not in the store any more"};
  }

  void finish(size_t index, NodeStatus status, const std::string& error) {
    State& state = states_[index];
    state.result.status = status;
    state.result.error = error;
    if (status != NodeStatus::executed && status != NodeStatus::reused) state.result.outputs.clear();
    observe([&] { observer_.node_finished(graph_.nodes[index], state.result); });
    for (const size_t follower : state.followers)
      if (--states_[follower].waiting == 0) group_.run([this, follower] { start(follower); });
  }

  template <typename Action>
  void observe(Action action) {
    const std::scoped_lock lock(observer_mutex_);
    action();
  }

  const Graph& graph_;
  const Registry& registry_;
  Store& store_;
  Observer& observer_;
  std::mutex observer_mutex_;
  MemoryBudget memory_;
  const int threads_;
  const std::string host_ = name_of_host();
  const std::atomic<bool> never_ = false;
  const std::atomic<bool>& cancel_;
  const bool isolate_all_;
  Workers workers_;
  WatchedRuns runs_;
  const bool remember_, anew_;
  std::once_flag last_read_;
  std::map<std::string, KeyFields> last_;  // of the pipeline's last run
  std::vector<State> states_;
  std::vector<std::map<std::string, Hashes>> outputs_;  // of the nodes that are done
  tbb::task_group group_;
};

}  // namespace

RunResult run_graph(const Graph& graph, const Registry& registry, Store& store, const RunOptions& options,
                    Observer& observer) {
  Execution execution(graph, registry, store, options, observer);
  return execution.run();
}

}  // namespace plumbline::runtime

#include "runtime/run/watched_run.hpp"

#include <oneapi/tbb/task_arena.h>

#include <atomic>

#include "runtime/base/running_nodes.hpp"

namespace plumbline::runtime {

namespace {

/// Of this process, for good: nobody knows which threads have it.
std::atomic<bool> a_mode_has_leaked = false;

std::string names_text(const std::set<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "'" : ", '") + name + "'";
  return text;
}

}  // namespace

NodeOutcome WatchedRuns::run(const NodeCall& call, NodeServices services) {
  const GraphNode& node = *call.node;
  NodeOutcome outcome;
  const auto run = [&] { tbb::this_task_arena::isolate([&] { outcome = run_node(call, services); }); };
  if (a_mode_has_leaked) services.workers = &workers_;
  if (services.workers || node.kind.plugin->executable) {  // what runs elsewhere changes nothing here
    run();
    return outcome;
  }
  std::string of_thread;
  SharedConditions::Finding found;
  {
    const RunningNode running(node.at.text() + ": node '" + node.name + "' (" + node.kind.node->kind + ")");
    const auto place = conditions_.begin(node.name);
    const ThreadConditions conditions;
    run();
    of_thread = conditions.changes();
    found = conditions_.end(place);
  }
  if (!of_thread.empty()) a_mode_has_leaked = true;
  if (outcome.cancelled || (of_thread.empty() && found.changes.empty())) return outcome;
  if (of_thread.empty() && found.runs.size() > 1) {
    services.workers = &workers_;
    run();
    if (!outcome.error.empty())
      outcome.error += "\n(it ran a second time, apart, because " + found.changes +
                       " changed while it ran beside others: " + names_text(found.runs) + ")";
    return outcome;
  }
  const std::string both = of_thread.empty() || found.changes.empty() ? "" : ", ";
  outcome.error = left_changed_text(of_thread + both + found.changes) +
                  (outcome.error.empty() ? "" : ". Besides: " + outcome.error);
  return outcome;
}

}  // namespace plumbline::runtime

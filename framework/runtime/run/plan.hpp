// What a run would do, and why, without computing anything.
#pragma once

#include <string>
#include <vector>

#include "runtime/run/read_for_plan.hpp"

namespace plumbline::runtime {

struct PlannedNode {
  size_t node = 0;      ///< in Graph::nodes
  size_t round = 0;     ///< GraphNode::round
  bool runs = false;    ///< it runs, or may run
  bool is_sure = true;  ///< false: it runs only if what it takes comes out otherwise than before
  size_t items = 0;     ///< how many are known; 0 if an input is still to be computed
  size_t items_to_run = 0;
  std::vector<std::string> reasons;  ///< why it runs, one line each
};

/// In the order of Graph::nodes; of a pipeline with rounds round by round, as far as they are in the store. A node
/// after one that runs cannot be looked up, because its key depends on outputs that are not there yet; it may still be
/// reused if those come out as before. Unless it was read for the plan: `read` has the outputs of nodes that always
/// run.
std::vector<PlannedNode> plan(const Graph& graph, Store& store, const ReadForPlan& read = {});

}  // namespace plumbline::runtime

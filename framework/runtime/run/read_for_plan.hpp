// What of a graph only reads files is run before a plan is made: what lies in a folder decides what a run computes.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "runtime/run/executor.hpp"

namespace plumbline::runtime {

/// What was read for a plan, by node.
struct ReadForPlan {
  std::vector<std::string> executed;  ///< what was not in the store before, in the graph's order
  std::map<std::string, std::map<std::string, Hashes>> outputs;  ///< blobs by port, of all that was read
  std::map<std::string, std::string> failures;                   ///< why a node failed
};

/// Nodes of a kind that is called `read.…`, which says that it reads files and computes nothing worth a wait, as far as
/// they take from such nodes alone; what stands between two of them (files handed to a reader of another plugin) too.
/// None that changes by rounds.
std::vector<bool> nodes_that_read(const Graph& graph);

/// Runs these nodes, or takes them from the store. What the store remembers of the pipeline's last run stays as it is.
ReadForPlan read_for_plan(const Graph& graph, const Registry& registry, Store& store);

}  // namespace plumbline::runtime

// What a run would do, and why, without running anything.
#pragma once

#include <string>
#include <vector>

#include "runtime/executor.hpp"

namespace plumbline::runtime {

struct PlannedNode {
  bool runs = false;
  size_t items = 0;  ///< how many are known; 0 if an input is still to be computed
  size_t items_to_run = 0;
  std::vector<std::string> reasons;  ///< why it runs, one line each
};

/// As Graph::nodes. A node after one that runs cannot be looked up, because its key depends on outputs that are not
/// there yet; it may still be reused if those come out as before.
std::vector<PlannedNode> plan(const Graph& graph, Store& store);

}  // namespace plumbline::runtime

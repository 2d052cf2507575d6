// One pass over a graph without rounds; executor.hpp says how.
#pragma once

#include "runtime/run/executor.hpp"

namespace plumbline::runtime {

RunResult run_graph(const Graph& graph, const Registry& registry, Store& store, const RunOptions& options,
                    Observer& observer);

}  // namespace plumbline::runtime

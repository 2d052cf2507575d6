// What a bench measures by itself: of a node that it compares, what the node's role says of how it is judged, by nodes
// that are the same for all alternatives. No alternative is asked how it started or how well it did.
#pragma once

#include <map>
#include <set>
#include <string>

#include "runtime/graph/graph.hpp"

namespace plumbline::runtime {

/// Adds to `graph` the measuring nodes of those of its nodes that are named in `compared`: quantity -> NODE.METRIC.
/// `judged` gets the names of the nodes. Left out is what cannot be measured there (an input that the measuring node
/// needs is not connected, its kind is not installed, the name is taken), what `given` measures already, and a role of
/// which two nodes are compared.
std::map<std::string, std::string> add_role_measures(Graph& graph, const std::set<std::string>& compared,
                                                     const std::map<std::string, std::string>& given,
                                                     const Registry& registry, std::set<std::string>& judged);

}  // namespace plumbline::runtime

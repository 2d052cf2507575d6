// From a pipeline's words to its graph: kinds, parameters, connections, types, frames, order, rounds.
#pragma once

#include <vector>

#include "runtime/graph/graph.hpp"
#include "runtime/graph/pipeline_file.hpp"

namespace plumbline::runtime {

/// What is wrong goes to `problems`; the graph is of use only if there is none.
Graph link_pipeline(const PipelineSpec& spec, const Registry& registry, std::vector<Problem>& problems);

/// "…: a, b": what there is, for a name that is not there.
std::string list_text(const std::vector<std::string>& names);

}  // namespace plumbline::runtime

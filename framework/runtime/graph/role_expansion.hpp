// `for_each: ROLE.PARAMETER` of a node: it stands once for each kind of the role, from whatever plugin, that declares
// the parameter. So a pipeline takes readers that nobody had written when it was.
#pragma once

#include <vector>

#include "runtime/graph/pipeline_file.hpp"

namespace plumbline::runtime {

/// Puts in place of every node with `for_each` one for each kind, "NODE_FAMILY_NAME". In its `use` and `with` the value
/// "${kind}" is the kind's name and "${kind.PARAMETER}" the default of its parameter. A connection between two such
/// nodes of one `for_each` stays within the kind; any other takes the outputs of all kinds, one after the other.
///
/// Where there is no kind, nodes that take from such nodes fall away, and with them the connections they give: what
/// they would have led to must not need them. A null `registry` knows no kinds. What is wrong goes to `problems`.
void expand_roles(PipelineSpec& spec, const Registry* registry, std::vector<Problem>& problems);

}  // namespace plumbline::runtime

// Parameters of a node, checked against their declaration and written in canonical form.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "runtime/graph/pipeline_file.hpp"

namespace plumbline::runtime {

/// Canonical text of every parameter of `node`, defaults included: equal values have equal texts, so that 2.0 and 2
/// share a cache key. Numbers in their shortest form, booleans true or false, paths absolute, items of a list joined by
/// '\x1f'. What is wrong goes to `problems`.
std::map<std::string, std::string> check_parameters(const Kind& kind, const NodeSpec& node,
                                                    std::vector<Problem>& problems);

}  // namespace plumbline::runtime

// Did you mean …?
#pragma once

#include <string>
#include <vector>

namespace plumbline::runtime {

/// Up to three of `candidates` that are near `wanted` (optimal string alignment distance), best first.
std::vector<std::string> near_names(const std::string& wanted, const std::vector<std::string>& candidates);

}  // namespace plumbline::runtime

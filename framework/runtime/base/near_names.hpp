// Did you mean …?
#pragma once

#include <string>
#include <vector>

namespace plumbline::runtime {

/// Up to three of `candidates` that are near `wanted` (optimal string alignment distance), best first.
std::vector<std::string> near_names(const std::string& wanted, const std::vector<std::string>& candidates);

/// " — did you mean 'a' or 'b'?", or nothing where none is near.
std::string did_you_mean(const std::string& wanted, const std::vector<std::string>& candidates);

}  // namespace plumbline::runtime

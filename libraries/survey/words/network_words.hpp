// How messages about a network are put together.
#pragma once

#include <string>
#include <vector>

namespace plumbline::survey {

/// "A, B, C and 4 more".
std::string join(const std::vector<std::string>& ids, size_t most = 12);

/// `value` with so many digits behind the point.
std::string fixed_digits(double value, int digits);

}  // namespace plumbline::survey

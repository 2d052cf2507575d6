// Small figures and words that several parts of the judgement use.
#pragma once

#include <algorithm>
#include <limits>
#include <string>
#include <vector>

#include "base/text/words.hpp"

namespace plumbline::judgement {

inline constexpr double nan = std::numeric_limits<double>::quiet_NaN();  ///< of what was not measured

/// "a, b and 4 more"
inline std::string list_of(const std::vector<std::string>& names, std::size_t most = 12) {
  return text::join(names, most);
}

}  // namespace plumbline::judgement

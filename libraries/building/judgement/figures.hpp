// Small figures and words that several parts of the judgement use.
#pragma once

#include <algorithm>
#include <limits>
#include <string>
#include <vector>

namespace plumbline::judgement {

inline constexpr double nan = std::numeric_limits<double>::quiet_NaN();  ///< of what was not measured

/// "a, b and 4 more"
inline std::string list_of(const std::vector<std::string>& names, std::size_t most = 12) {
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), most); ++i) text += (i > 0 ? ", " : "") + names[i];
  return names.size() > most ? text + " and " + std::to_string(names.size() - most) + " more" : text;
}

}  // namespace plumbline::judgement

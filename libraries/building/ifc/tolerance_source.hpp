// Where a tolerance comes from, as verdicts carry it in words (PanelLimit.source, JudgedAxis.source).
#pragma once

#include <algorithm>
#include <cctype>
#include <string>
#include <string_view>
#include <vector>

namespace plumbline::ifc {

/// What the words of a tolerance begin with that nobody asked for: the common one that is assumed.
inline constexpr std::string_view kDefaultTolerance = "default";

inline bool is_default_tolerance(std::string_view source) { return source.starts_with(kDefaultTolerance); }

/// A name without what people write differently: case, blanks, underscores.
inline std::string bare_name(std::string_view name) {
  std::string bare;
  for (const char c : name)
    if (std::isalnum(static_cast<unsigned char>(c)))
      bare += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return bare;
}

/// Whether a property set is the standard's Pset_Tolerance, in whatever case and with whatever blanks it is written.
inline bool is_tolerance_set(std::string_view name) { return bare_name(name) == "psettolerance"; }

/// Whether it may have been meant: two letters more, less or otherwise (Pset_Tolerances, PSet_Tolerence).
inline bool is_like_tolerance_set(std::string_view name) {
  constexpr std::string_view meant = "psettolerance";
  constexpr std::size_t kLetters = 2;
  const std::string bare = bare_name(name);
  if (bare.size() + kLetters < meant.size() || bare.size() > meant.size() + kLetters) return false;
  std::vector<std::size_t> row(meant.size() + 1), next(row);  // Levenshtein's distance
  for (std::size_t k = 0; k < row.size(); ++k) row[k] = k;
  for (std::size_t i = 0; i < bare.size(); ++i) {
    next[0] = i + 1;
    for (std::size_t k = 0; k < meant.size(); ++k)
      next[k + 1] = std::min({next[k] + 1, row[k + 1] + 1, row[k] + (bare[i] == meant[k] ? 0 : 1)});
    std::swap(row, next);
  }
  return row.back() <= kLetters;
}

}  // namespace plumbline::ifc

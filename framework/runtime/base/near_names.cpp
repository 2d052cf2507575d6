#include "runtime/base/near_names.hpp"

#include <algorithm>

namespace plumbline::runtime {

namespace {

/// Edits (insert, delete, replace, swap neighbours) between two words.
size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::vector<size_t>> d(a.size() + 1, std::vector<size_t>(b.size() + 1));
  for (size_t i = 0; i <= a.size(); ++i) d[i][0] = i;
  for (size_t j = 0; j <= b.size(); ++j) d[0][j] = j;
  for (size_t i = 1; i <= a.size(); ++i)
    for (size_t j = 1; j <= b.size(); ++j) {
      d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, d[i - 1][j - 1] + (a[i - 1] != b[j - 1])});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
    }
  return d[a.size()][b.size()];
}

}  // namespace

std::vector<std::string> near_names(const std::string& wanted, const std::vector<std::string>& candidates) {
  std::vector<std::pair<size_t, std::string>> ranked;
  if (wanted.size() > 200) return {};
  for (const std::string& candidate : candidates) {
    size_t distance = edit_distance(wanted, candidate);
    // "opengv" for "pose.opengv": a whole part of a dotted name counts as near.
    if (distance > 1 && wanted.size() > 2 && candidate.find(wanted) != std::string::npos) distance = 1;
    if (distance <= std::max<size_t>(1, wanted.size() / 3)) ranked.emplace_back(distance, candidate);
  }
  std::sort(ranked.begin(), ranked.end());
  std::vector<std::string> names;
  for (size_t i = 0; i < ranked.size() && i < 3; ++i) names.push_back(ranked[i].second);
  return names;
}

std::string did_you_mean(const std::string& wanted, const std::vector<std::string>& candidates) {
  const auto near = near_names(wanted, candidates);
  if (near.empty()) return "";
  std::string text = " — did you mean ";
  for (size_t i = 0; i < near.size(); ++i) text += (i ? " or '" : "'") + near[i] + "'";
  return text + "?";
}

}  // namespace plumbline::runtime

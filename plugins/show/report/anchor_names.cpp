#include "show/report/anchor_names.hpp"

#include <algorithm>

namespace plumbline::report {

namespace {

constexpr const char* separators = "-_./ ";

/// What both texts begin with.
std::string shared_start(const std::string& a, const std::string& b) {
  return {a.begin(), std::mismatch(a.begin(), a.end(), b.begin(), b.end()).first};
}

}  // namespace

std::map<int, std::string> common_prefixes(const AccuracyT& accuracy) {
  std::map<int, std::pair<std::string, int>> shared;  // prefix, number of anchors
  for (const auto& a : accuracy.anchors) {
    auto& [prefix, number] = shared[a->floor];
    prefix = number++ == 0 ? a->id : shared_start(prefix, a->id);
  }
  std::map<int, std::string> prefixes;
  for (const auto& [floor, entry] : shared) {
    const auto separator = entry.first.find_last_of(separators);
    if (floor > 0 && entry.second > 1 && separator != std::string::npos)
      prefixes[floor] = entry.first.substr(0, separator + 1);
  }
  return prefixes;
}

std::map<int, std::string> column_names(const AccuracyT& accuracy) {
  const std::map<int, std::string> prefixes = common_prefixes(accuracy);
  std::map<int, std::string> names;
  std::map<int, bool> whole;  // every name of the column is the same without the floor's part
  for (const auto& a : accuracy.anchors) {
    if (a->column <= 0) continue;
    const auto prefix = prefixes.find(a->floor);
    const std::string name = a->id.substr(prefix == prefixes.end() ? 0 : prefix->second.size());
    const auto [known, added] = names.emplace(a->column, name);
    const bool same = added || known->second == name;
    whole[a->column] = (added || whole[a->column]) && same;
    if (!same) known->second = shared_start(known->second, name);
  }
  for (auto& [column, name] : names) {
    if (!whole[column]) {
      const auto separator = name.find_last_of(separators);
      name = separator == std::string::npos ? "" : name.substr(0, separator);
    }
    if (name.empty()) name = "column " + std::to_string(column);
  }
  return names;
}

std::string end_of(const std::string& name) {
  constexpr std::size_t kShort = 12, kEnd = 7;
  if (name.size() <= kShort) return name;
  std::size_t at = name.size() - kEnd;
  while ((static_cast<unsigned char>(name[at]) & 0xC0U) == 0x80U) ++at;  // within a character of UTF-8
  return "\u2026" + name.substr(at);
}

}  // namespace plumbline::report

#include "markers/camera_groups.hpp"

#include <set>

namespace plumbline::markers {
namespace {

/// First and last digit of the last number of the name; npos if it has none.
std::pair<size_t, size_t> last_number(const std::string& path) {
  const size_t slash = path.find_last_of('/'), name = slash == std::string::npos ? 0 : slash + 1;
  const size_t dot = path.find_last_of('.'), end = dot == std::string::npos || dot < name ? path.size() : dot;
  size_t last = end;
  while (last > name && !(path[last - 1] >= '0' && path[last - 1] <= '9')) --last;
  if (last == name) return {std::string::npos, std::string::npos};
  size_t first = last;
  while (first > name && path[first - 1] >= '0' && path[first - 1] <= '9') --first;
  return {first, last};
}

}  // namespace

std::string folder_of(const std::string& path) {
  const size_t slash = path.find_last_of('/');
  return slash == std::string::npos ? "" : path.substr(0, slash);
}

std::string prefix_of(const std::string& path) {
  const auto [first, last] = last_number(path);
  if (first == std::string::npos) return folder_of(path);
  std::string prefix = path.substr(0, first);
  while (!prefix.empty() && std::string("_-. /").find(prefix.back()) != std::string::npos) prefix.pop_back();
  return prefix;
}

std::string camera_name(const std::string& path, const std::string& by) {
  return by == "by_folder" ? folder_of(path) : by == "by_name" ? prefix_of(path) : "";
}

std::string moment_of(const std::string& path) {
  const auto [first, last] = last_number(path);
  if (first == std::string::npos) return path.substr(path.find_last_of('/') + 1);
  std::string number = path.substr(first, last - first);
  number.erase(0, std::min(number.find_first_not_of('0'), number.size() - 1));
  return number;
}

std::string suspected_cameras(const std::vector<std::string>& paths) {
  std::map<std::string, std::map<std::string, std::set<std::string>>> moments;  // by folder and beginning
  for (const auto& path : paths) moments[folder_of(path)][prefix_of(path)].insert(moment_of(path));
  for (const auto& [folder, beginnings] : moments) {
    std::vector<std::string> names;
    std::set<std::string> all;
    size_t photographs = 0;
    for (const auto& [beginning, own] : beginnings)
      if (own.size() >= 3) {
        names.push_back(beginning), photographs += own.size();
        all.insert(own.begin(), own.end());
      }
    // Names that only count on share no moments.
    if (names.size() < 2 || 2 * (photographs - all.size()) < all.size()) continue;
    std::string text;
    for (size_t i = 0; i < names.size(); ++i) text += (i == 0 ? "" : i + 1 == names.size() ? " and " : ", ") + names[i];
    return text;
  }
  return "";
}

}  // namespace plumbline::markers

#include "markers/camera_groups.hpp"

#include <algorithm>
#include <cctype>
#include <set>

namespace plumbline::markers {
namespace {

constexpr size_t npos = std::string::npos;

struct NumberedName {
  size_t name = 0, end = 0;            ///< of the path, without folder and ending
  size_t first = npos, behind = npos;  ///< of the number that counts the moments; npos without one
};

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// Whether `text` ends in what cameras are numbered with: "cam", "rig_cam_", "Camera-".
bool numbers_a_camera(std::string text) {
  if (!text.empty() && std::string("_- ").find(text.back()) != npos) text.pop_back();
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text.ends_with("cam") || text.ends_with("camera");
}

/// The last number, of a camera ("0017_cam2") only if there is no other.
NumberedName numbered(const std::string& path) {
  const size_t slash = path.find_last_of('/'), dot = path.find_last_of('.');
  NumberedName result;
  result.name = slash == npos ? 0 : slash + 1;
  result.end = dot == npos || dot < result.name ? path.size() : dot;
  for (size_t last = result.end; last > result.name;) {
    if (!is_digit(path[last - 1])) {
      --last;
      continue;
    }
    size_t first = last;
    while (first > result.name && is_digit(path[first - 1])) --first;
    const bool camera = numbers_a_camera(path.substr(result.name, first - result.name));
    if (result.first == npos || !camera) result.first = first, result.behind = last;
    if (!camera) break;
    last = first;
  }
  return result;
}

std::string trimmed(const std::string& text) {
  const size_t first = text.find_first_not_of("_-. "), last = text.find_last_not_of("_-. ");
  return first == npos ? "" : text.substr(first, last - first + 1);
}

}  // namespace

std::string folder_of(const std::string& path) {
  const size_t slash = path.find_last_of('/');
  return slash == std::string::npos ? "" : path.substr(0, slash);
}

std::string name_around_number(const std::string& path) {
  const NumberedName n = numbered(path);
  std::string folder = folder_of(path);
  if (n.first == npos) return folder;
  const std::string before = trimmed(path.substr(n.name, n.first - n.name)),
                    behind = trimmed(path.substr(n.behind, n.end - n.behind)),
                    name = before + (before.empty() || behind.empty() ? "" : "_") + behind;
  return folder + (folder.empty() || name.empty() ? "" : "/") + name;
}

std::string camera_name(const std::string& path, const std::string& by) {
  return by == "by_folder" ? folder_of(path) : by == "by_name" ? name_around_number(path) : "";
}

std::string moment_of(const std::string& path) {
  const NumberedName n = numbered(path);
  if (n.first == npos) return path.substr(n.name);
  std::string number = path.substr(n.first, n.behind - n.first);
  number.erase(0, std::min(number.find_first_not_of('0'), number.size() - 1));
  return number;
}

std::string suspected_cameras(const std::vector<std::string>& paths) {
  std::map<std::string, std::map<std::string, std::set<std::string>>> moments;  // by folder and camera
  for (const auto& path : paths) moments[folder_of(path)][name_around_number(path)].insert(moment_of(path));
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

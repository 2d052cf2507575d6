#include "photo/cameras/camera_groups.hpp"

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <set>
#include <tuple>

namespace plumbline::cameras {
namespace {

constexpr size_t npos = std::string::npos;
constexpr size_t kStampDigits = 10;  // numbers this long are times: seconds and finer since 1970

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

/// Where the number that ends before `last` begins; seconds with their fraction ("1403636579.763555") are one number.
size_t first_of_number(const std::string& path, size_t name, size_t last) {
  const auto run = [&](size_t end) {
    while (end > name && is_digit(path[end - 1])) --end;
    return end;
  };
  const size_t first = run(last);
  if (first <= name + kStampDigits || path[first - 1] != '.') return first;
  const size_t seconds = run(first - 1);
  return first - 1 - seconds >= kStampDigits ? seconds : first;
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
    const size_t first = first_of_number(path, result.name, last);
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

std::string stem_of(const std::string& path) {
  const NumberedName n = numbered(path);
  return path.substr(n.name, n.end - n.name);
}

/// "cam0" of "0001/cam0.png" and of "0001/cam0_0001.png": the name of the file, less the number that is its folder's.
std::string name_in_folder(const std::string& path) {
  const NumberedName n = numbered(path);
  const std::string folder = folder_of(path);
  constexpr size_t long_enough = 3;  // "1/img_1.png": not every 1 is that of the folder
  if (n.first == npos || n.behind - n.first < long_enough ||
      folder.find(path.substr(n.first, n.behind - n.first)) == npos)
    return stem_of(path);
  const std::string name = name_around_number(path);
  return name == folder ? stem_of(path) : name.substr(folder.size() + 1);
}

/// Whether a name is that of a camera and not of a photograph: "left", "cam0", "rig_cam_2", but not "IMG_0001".
bool names_a_camera(const std::string& name) {
  for (size_t i = 0; i < name.size(); ++i)
    if (is_digit(name[i]) && (i == 0 || (!is_digit(name[i - 1]) && !numbers_a_camera(name.substr(0, i))))) return false;
  return !name.empty();
}

/// Whether every folder is a moment and the files in it are the cameras' photographs: "0001/cam0.png".
bool folders_are_moments(const std::vector<std::string>& paths) {
  std::set<std::string> folders, names;
  std::set<std::pair<std::string, std::string>> photographs;
  for (const auto& path : paths) {
    const std::string folder = folder_of(path), name = name_in_folder(path);
    const std::string last = folder.substr(folder.find_last_of('/') + 1);
    if (!names_a_camera(name) || std::none_of(last.begin(), last.end(), is_digit) || names_a_camera(last)) return false;
    folders.insert(folder), names.insert(name), photographs.emplace(folder, name);
  }
  return photographs.size() == paths.size() && folders.size() >= 3 && names.size() >= 2 &&
         2 * photographs.size() >= folders.size() * names.size();
}

bool is_time_stamp(const std::string& moment) {
  return moment.size() >= kStampDigits && moment.find_first_not_of("0123456789.") == npos;
}

struct Stamp {
  double time = 0;
  size_t camera = 0, index = 0;
};

/// A quarter of the shortest time between two photographs of one camera, `stamps` in the order of time.
double same_moment_within(const std::vector<Stamp>& stamps, size_t cameras) {
  std::vector<double> last(cameras, -1);
  double shortest = -1;
  for (const Stamp& s : stamps) {
    const double between = s.time - last[s.camera];
    if (last[s.camera] >= 0 && between > 0 && (shortest < 0 || between < shortest)) shortest = between;
    last[s.camera] = s.time;
  }
  return std::max(0.0, 0.25 * shortest);
}

/// Gives time stamps that are the same moment the name of the first of them.
void join_time_stamps(std::vector<std::vector<std::string>>& moments) {
  std::vector<Stamp> stamps;
  for (size_t c = 0; c < moments.size(); ++c)
    for (size_t i = 0; i < moments[c].size(); ++i) {
      if (!is_time_stamp(moments[c][i])) return;
      stamps.push_back({std::strtod(moments[c][i].c_str(), nullptr), c, i});
    }
  std::sort(stamps.begin(), stamps.end(), [](const Stamp& a, const Stamp& b) {
    return std::tie(a.time, a.camera, a.index) < std::tie(b.time, b.camera, b.index);
  });
  const double within = same_moment_within(stamps, moments.size());
  size_t first = 0;
  for (size_t k = 0; k < stamps.size(); ++k) {
    if (stamps[k].time - stamps[first].time > within) first = k;
    moments[stamps[k].camera][stamps[k].index] = moments[stamps[first].camera][stamps[first].index];
  }
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
  if (by == "by_file") return name_in_folder(path);
  return by == "by_folder" ? folder_of(path) : by == "by_name" ? name_around_number(path) : "";
}

std::string cameras_told(const std::vector<std::string>& paths, const std::string& by) {
  return (by == "by_folder" || by == "by_name") && folders_are_moments(paths) ? "by_file" : by;
}

std::string moment_of(const std::string& path, const std::string& by) {
  if (by == "by_file") return folder_of(path);
  const NumberedName n = numbered(path);
  if (n.first == npos) return path.substr(n.name);
  std::string number = path.substr(n.first, n.behind - n.first);
  number.erase(0, std::min(number.find_first_not_of('0'), number.size() - 1));
  return number;
}

std::vector<std::vector<std::string>> moments_of(const std::vector<std::vector<std::string>>& paths,
                                                 const std::string& by) {
  std::vector<std::vector<std::string>> moments;
  for (const auto& of_one : paths) {
    moments.emplace_back();
    for (const auto& path : of_one) moments.back().push_back(moment_of(path, by));
  }
  if (by != "by_file") join_time_stamps(moments);
  return moments;
}

std::string suspected_cameras(const std::vector<std::string>& paths) {
  std::map<std::string, std::map<std::string, std::set<std::string>>> moments;  // by folder and camera
  for (const auto& path : paths) moments[folder_of(path)][name_around_number(path)].insert(moment_of(path, "by_name"));
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

}  // namespace plumbline::cameras

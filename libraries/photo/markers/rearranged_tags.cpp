#include "photo/markers/rearranged_tags.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <map>
#include <utility>
#include <vector>

#include "geometry/median.hpp"
#include "photo/markers/marker_model.hpp"

namespace plumbline::markers {
namespace {

struct SeenDistance {
  double metres = 0;
  int image = 0;
};

/// By pair of markers, in every photograph that shows both. `is_guessed`: nothing tells the principal distance of a
/// camera, and distances along the view are as wrong as what is taken for it.
std::map<std::pair<int, int>, std::vector<SeenDistance>> distances_of(const MarkerBlock& block, bool& is_guessed) {
  std::vector<BrownCamera> cameras;
  for (std::size_t c = 0; c < block.cameras.size(); ++c) {
    BrownCamera camera = block.cameras[c].camera;
    if (!(camera.fx > 0)) {
      const double extent = std::max(camera.width, camera.height),
                   f = focal_length_from_tags(block, static_cast<int>(c));
      const bool is_told = f > 0.4 * extent && f < 8 * extent;
      is_guessed = is_guessed || !is_told;
      camera.fx = camera.fy = is_told ? f : 1.2 * extent;
      camera.cx = 0.5 * (camera.width - 1), camera.cy = 0.5 * (camera.height - 1);
    }
    cameras.push_back(camera);
  }
  std::map<int, std::vector<std::pair<int, Eigen::Vector3d>>> places;  // by image: marker, in the camera's frame
  for (const MarkerView& view : block.views) {
    const int camera = block.images[view.image].camera;
    const auto poses = poses_of_view(block, view, cameras[camera]);
    if (!poses.empty()) places[view.image].emplace_back(view.marker, poses.front().cam_from_figure.translation);
  }
  std::map<std::pair<int, int>, std::vector<SeenDistance>> distances;
  for (const auto& [image, seen] : places)
    for (const auto& [a, at_a] : seen)
      for (const auto& [b, at_b] : seen)
        if (a < b) distances[{a, b}].push_back({(at_a - at_b).norm(), image});
  return distances;
}

/// The one tag that all pairs which moved have in common, where most of its own did; else -1.
int common_tag(const std::vector<std::pair<int, int>>& moved, const std::map<int, int>& pairs_of) {
  for (const int tag : {moved.front().first, moved.front().second}) {
    const bool in_all = std::all_of(moved.begin(), moved.end(),
                                    [&](const auto& pair) { return pair.first == tag || pair.second == tag; });
    if (in_all && 2 * static_cast<int>(moved.size()) > pairs_of.at(tag)) return tag;
  }
  return -1;
}

/// What two halves of the photographs say of the pairs that both show.
struct Cut {
  int image = 0, pairs = 0, moved = 0;  // the first photograph behind it
  double furthest = 0;                  // of the distance
  std::pair<int, int> pair;             // that which changed most
  double before = 0, behind = 0;        // [m] between its tags
  double scatter = 0;                   // of all distances about those of their sides
  bool is_clear() const { return moved >= 3 && 2 * moved > pairs; }
};

/// At a cut before an image each side has a distance of its own. It changed where the two differ by more than five
/// standard deviations of one distance (1.48 times the median of the absolute deviations on its own side) and by a
/// twelfth of it: single tags tell a distance along the view to some hundredths.
Cut cut_before(int image, const std::map<std::pair<int, int>, std::vector<SeenDistance>>& distances) {
  constexpr double kSigmas = 5, kLeast = 1.0 / 12;
  Cut cut;
  cut.image = image;
  for (const auto& [pair, seen] : distances) {
    std::vector<double> sides[2], deviations;
    for (const SeenDistance& each : seen) sides[each.image >= image].push_back(each.metres);
    double middle[2] = {0, 0};
    for (const int side : {0, 1}) {
      if (!sides[side].empty()) middle[side] = upper_median(sides[side]);
      for (const double metres : sides[side]) deviations.push_back(std::abs(metres - middle[side]));
    }
    for (const double deviation : deviations) cut.scatter += deviation;
    if (sides[0].size() < 2 || sides[1].size() < 2) continue;
    const auto [before, behind] = middle;
    const double off = std::abs(before - behind), larger = std::max(before, behind);
    ++cut.pairs;
    if (off < kLeast * larger || off < kSigmas * 1.48 * upper_median(deviations)) continue;
    ++cut.moved;
    if (off > cut.furthest * larger)
      cut.furthest = off / larger, cut.pair = pair, cut.before = before, cut.behind = behind;
  }
  return cut;
}

/// The tags were hung elsewhere once, between two photographs: more than half of the pairs changed there. Empty: they
/// were not.
std::string hung_again(const MarkerBlock& block,
                       const std::map<std::pair<int, int>, std::vector<SeenDistance>>& distances) {
  constexpr std::ptrdiff_t kMostCuts = 200;  // of thousands of photographs the nearest of so many
  Cut best;
  const int step = static_cast<int>(1 + std::ssize(block.images) / kMostCuts);
  for (int image = 2; image + 2 <= std::ssize(block.images); image += step)
    if (const Cut cut = cut_before(image, distances);
        cut.is_clear() && (!best.is_clear() || cut.scatter < best.scatter))
      best = cut;
  if (!best.is_clear()) return "";
  return fmt::format(
      "the tags stand elsewhere from {} on: {} of {} pairs that are seen before and behind it have another distance, "
      "tags {} and {} {:.2f} m before and {:.2f} m from there on. A folder for each arrangement",
      block.images[best.image].path, best.moved, best.pairs, block.markers[best.pair.first].name(),
      block.markers[best.pair.second].name(), best.before, best.behind);
}

}  // namespace

std::string rearranged_tags(const MarkerBlock& block) {
  constexpr double apart = 0.25;  // of the distance
  bool is_guessed = false;
  const auto distances = distances_of(block, is_guessed);
  int pairs = 0, moved = 0;
  double furthest = 0;
  std::string example;
  std::map<int, int> times, pairs_of;  // in pairs that moved, and in all
  std::vector<std::pair<int, int>> moved_pairs;
  for (const auto& [pair, seen] : distances) {
    if (seen.size() < 2) continue;
    ++pairs, ++pairs_of[pair.first], ++pairs_of[pair.second];
    const auto [least, most] =
        std::minmax_element(seen.begin(), seen.end(), [](const auto& a, const auto& b) { return a.metres < b.metres; });
    std::vector<double> all;
    for (const SeenDistance& each : seen) all.push_back(each.metres);
    const Marker &a = block.markers[pair.first], &b = block.markers[pair.second];
    const double allowed = apart * upper_median(all) + std::max(a.size, b.size), off = most->metres - least->metres;
    if (!(off > allowed)) continue;
    ++moved, ++times[pair.first], ++times[pair.second];
    moved_pairs.push_back(pair);
    if (!(off / allowed > furthest)) continue;
    furthest = off / allowed;
    example = fmt::format("tags {} and {} are {:.2f} m apart in {} and {:.2f} m in {}", a.name(), b.name(),
                          least->metres, block.images[least->image].path, most->metres, block.images[most->image].path);
  }
  const std::string once = is_guessed ? "" : hung_again(block, distances);
  if (moved < 2) return once;
  if (const int one = common_tag(moved_pairs, pairs_of); one >= 0)
    return "tag " + block.markers[one].name() +
           " stands elsewhere from photograph to photograph, or two tags carry that number: " + example +
           ". Take it out, or print every id once and photograph an arrangement that stays";
  if (!once.empty()) return once;
  if (2 * moved < pairs) return "";
  std::string names;
  for (const auto& [marker, count] : times) names += (names.empty() ? "" : ", ") + block.markers[marker].name();
  return "the tags stand elsewhere from photograph to photograph, or several tags have one number: " + example +
         "; so do " + std::to_string(moved) + " of " + std::to_string(pairs) +
         " pairs that are seen together more than once (tags " + names +
         "). Photograph an arrangement that stays, or a folder for each arrangement; print every id once";
}

}  // namespace plumbline::markers

#include "photo/markers/tag_places.hpp"

#include <fmt/core.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include "base/text/name_order.hpp"
#include "geometry/camera.hpp"
#include "geometry/median.hpp"

namespace plumbline::markers {
namespace {

constexpr size_t fewest = 3;  // photographs at a place
/// Without an order to hold to, few rays meet somewhere by chance: seen with three and four in blocks with blunders.
constexpr size_t fewest_anyhow = 5;

/// The ray to a tag's centre in the world.
struct Sight {
  int view = 0;
  Eigen::Vector3d from, along;
  double pixels = 0;  ///< a radian
};
using Sights = std::vector<Sight>;

/// The centre of a square is where its diagonals meet, seen from wherever.
std::optional<Eigen::Vector3d> towards_centre(const InteriorOrientation& camera,
                                              const std::array<Eigen::Vector2d, 4>& corners) {
  std::array<Eigen::Vector3d, 4> rays;
  for (size_t k = 0; k < rays.size(); ++k) {
    const auto at = unproject(camera, corners[k]);
    if (!at) return std::nullopt;
    rays[k] = at->homogeneous();
  }
  Eigen::Vector3d centre = rays[0].cross(rays[2]).cross(rays[1].cross(rays[3]));
  if (centre.z() < 0) centre = -centre;
  return centre.normalized();
}

/// By marker, in the order of the photographs' names. A photograph that its other tags do not hold says nothing.
std::map<int, Sights> sights_of(const MarkerBlock& block, const MarkerStart& placed, const std::vector<bool>& use) {
  constexpr int held_by = 2;
  std::vector<int> tags(block.images.size(), 0), order(block.views.size());
  for (size_t v = 0; v < block.views.size(); ++v) tags[block.views[v].image] += use[v], order[v] = static_cast<int>(v);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
    return text::before_by_name(block.images[block.views[a].image].path, block.images[block.views[b].image].path);
  });
  std::map<int, Sights> sights;
  for (const int v : order) {
    const MarkerView& view = block.views[v];
    const auto& pose = placed.cam_from_world[view.image];
    if (!pose || tags[view.image] - (use[v] ? 1 : 0) < held_by) continue;
    const BrownCamera& camera = placed.cameras[block.images[view.image].camera];
    if (const auto ray = towards_centre(camera, view.corners))
      sights[view.marker].push_back({v, pose->inverse().translation, pose->rotation.conjugate() * *ray, camera.fx});
  }
  return sights;
}

/// Where rays meet, and the root mean square of what they miss it by [px].
struct Meeting {
  Eigen::Vector3d place;
  double squares = std::numeric_limits<double>::infinity();
};

double miss(const Sight& sight, const Eigen::Vector3d& place) {
  const Eigen::Vector3d to = place - sight.from;
  return sight.along.cross(to.normalized()).norm() * sight.pixels + (sight.along.dot(to) > 0 ? 0 : 1e6);
}

Meeting meeting_of(const Sights& sights) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const Sight& sight : sights) {
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - sight.along * sight.along.transpose();
    normal += across, right += across * sight.from;
  }
  Meeting meeting;
  const Eigen::FullPivLU<Eigen::Matrix3d> decomposition(normal);
  if (!decomposition.isInvertible()) return meeting;
  meeting.place = decomposition.solve(right), meeting.squares = 0;
  for (const Sight& sight : sights) meeting.squares += std::pow(miss(sight, meeting.place), 2);
  return meeting;
}

double misfit(double squares, size_t sights) { return std::sqrt(squares / static_cast<double>(sights)); }

/// Two sets of rays, and what they miss their places by.
struct Parted {
  std::array<Sights, 2> parts;
  std::array<Meeting, 2> meetings;
  double rms() const { return misfit(meetings[0].squares + meetings[1].squares, parts[0].size() + parts[1].size()); }
  bool enough(size_t least = fewest) const { return std::min(parts[0].size(), parts[1].size()) >= least; }
};

Parted parted(Sights first, Sights second) {
  Parted result{{std::move(first), std::move(second)}, {}};
  if (result.enough()) result.meetings = {meeting_of(result.parts[0]), meeting_of(result.parts[1])};
  return result;
}

/// Before and after, at the photograph where that fits best.
Parted parted_in_order(const Sights& sights) {
  Parted best;
  double least = std::numeric_limits<double>::infinity();
  for (size_t at = fewest; at + fewest <= sights.size(); ++at) {
    const auto middle = sights.begin() + static_cast<std::ptrdiff_t>(at);
    Parted parts = parted({sights.begin(), middle}, {middle, sights.end()});
    if (parts.rms() < least) least = parts.rms(), best = std::move(parts);
  }
  return best;
}

/// In whatever order: of each pair of rays the place where they meet, and who meets them there.
Parted parted_anyhow(const Sights& sights, double allowed) {
  constexpr size_t most = 40;  // that are tried in pairs
  Parted best;
  double least = std::numeric_limits<double>::infinity();
  for (size_t i = 0; i < std::min(most, sights.size()); ++i)
    for (size_t j = i + 1; j < std::min(most, sights.size()); ++j) {
      const Meeting pair = meeting_of({sights[i], sights[j]});
      if (!std::isfinite(pair.squares)) continue;
      std::array<Sights, 2> parts;
      for (const Sight& sight : sights) parts[miss(sight, pair.place) > 2 * allowed].push_back(sight);
      Parted found = parted(std::move(parts[0]), std::move(parts[1]));
      if (found.enough() && found.rms() < least) least = found.rms(), best = std::move(found);
    }
  return best;
}

TagAtTwoPlaces as_found(int marker, bool in_order, const Parted& parts) {
  TagAtTwoPlaces found;
  found.marker = marker, found.in_order = in_order;
  for (size_t k = 0; k < 2; ++k) {
    found.places[k] = parts.meetings[k].place;
    for (const Sight& sight : parts.parts[k]) found.views[k].push_back(sight.view);
  }
  return found;
}

const std::string& path_of(const MarkerBlock& block, int view) { return block.images[block.views[view].image].path; }

std::string in_words(double metres) {
  return metres < 1 ? fmt::format("{:.1f} mm", 1e3 * metres) : fmt::format("{:.2f} m", metres);
}

std::string photographs(size_t n) { return std::to_string(n) + (n == 1 ? " photograph" : " photographs"); }

/// The other tag that came to where this one was, before the same photograph; none: nullptr.
const TagAtTwoPlaces* exchanged_with(const MarkerBlock& block, const TagAtTwoPlaces& tag,
                                     const std::vector<TagAtTwoPlaces>& found) {
  for (const TagAtTwoPlaces& other : found) {
    if (other.marker == tag.marker || !other.in_order || !tag.in_order) continue;
    const double near = 0.5 * block.markers[tag.marker].size;
    if ((other.places[1] - tag.places[0]).norm() < near && (tag.places[1] - other.places[0]).norm() < near)
      return &other;
  }
  return nullptr;
}

}  // namespace

std::vector<TagAtTwoPlaces> tags_at_two_places(const MarkerBlock& block, const MarkerStart& placed,
                                               const std::vector<bool>& use) {
  constexpr double fits = 4, does_not = 5, least_unit = 0.02;  // in the misfit of tags that stayed; [px]
  constexpr double clearly = 0.5;  // of the misfit of one place: any two places fit better than one
  const std::map<int, Sights> sights = sights_of(block, placed, use);
  std::vector<double> sound;
  for (const auto& [marker, seen] : sights) {
    const bool whole = std::all_of(seen.begin(), seen.end(), [&](const Sight& s) { return use[s.view]; });
    if (whole && seen.size() >= fewest) sound.push_back(misfit(meeting_of(seen).squares, seen.size()));
  }
  std::vector<TagAtTwoPlaces> found;
  if (sound.empty()) return found;
  const double unit = std::max(least_unit, median(sound));
  for (const auto& [marker, seen] : sights) {
    const double whole = misfit(meeting_of(seen).squares, seen.size());
    if (seen.size() < 2 * fewest || !(whole > does_not * unit)) continue;
    const Parted in_order = parted_in_order(seen);
    if (in_order.enough() && in_order.rms() < std::min(fits * unit, clearly * whole)) {
      found.push_back(as_found(marker, true, in_order));
      continue;
    }
    const Parted anyhow = parted_anyhow(seen, fits * unit);
    if (anyhow.enough(fewest_anyhow) && anyhow.rms() < std::min(fits * unit, clearly * whole))
      found.push_back(as_found(marker, false, anyhow));
  }
  return found;
}

std::vector<std::string> words_of(const MarkerBlock& block, const std::vector<TagAtTwoPlaces>& found) {
  std::vector<std::string> words;
  for (const TagAtTwoPlaces& tag : found) {
    const std::string name = block.markers[tag.marker].name();
    const size_t kept = tag.larger();
    const std::string first_after = path_of(block, tag.views[1].front());
    const std::string effect = "; " + photographs(tag.views[1 - kept].size()) + " of it " +
                               (tag.views[1 - kept].size() == 1 ? "is" : "are") + " left out, and it stands where " +
                               (!tag.in_order ? "most have it"
                                : kept == 0   ? "it was before"
                                              : "it came to");
    const TagAtTwoPlaces* other = exchanged_with(block, tag, found);
    if (other && other->marker < tag.marker) continue;
    if (other)
      words.push_back("tags " + name + " and " + block.markers[other->marker].name() + " changed places before " +
                      first_after + " (by the order of the names)" + effect);
    else if (tag.in_order)
      words.push_back("tag " + name + " was moved by " + in_words(tag.distance()) + " before " + first_after +
                      " (by the order of the names)" +
                      (tag.distance() > block.markers[tag.marker].size ? ", or two tags carry that number" : "") +
                      effect);
    else
      words.push_back("tag " + name + " stands at two places " + in_words(tag.distance()) + " apart, such as in " +
                      path_of(block, tag.views[kept].front()) + " and in " +
                      path_of(block, tag.views[1 - kept].front()) +
                      ": two tags carry that number, or it was moved to and fro" + effect);
  }
  return words;
}

std::vector<std::string> words_of_rejected(const MarkerBlock& block, const MarkerResult& result,
                                           const std::vector<TagAtTwoPlaces>& explained) {
  constexpr size_t few = 3;
  std::map<int, std::pair<size_t, size_t>> counts;  // left out, of all
  for (const MarkerView& view : block.views) ++counts[view.marker].second;
  for (const int v : result.rejected) ++counts[block.views[v].marker].first;
  for (const TagAtTwoPlaces& tag : explained) counts.erase(tag.marker);
  std::vector<std::string> words;
  for (const auto& [marker, count] : counts)
    if (count.first >= few && 3 * count.first > count.second)
      words.push_back("tag " + block.markers[marker].name() + ": " + std::to_string(count.first) + " of its " +
                      photographs(count.second) +
                      " contradict the others and are left out; was it moved, bent, or half covered?");
  return words;
}

}  // namespace plumbline::markers

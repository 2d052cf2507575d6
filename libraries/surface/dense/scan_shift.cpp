#include "surface/dense/scan_shift.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace plumbline::surface {
namespace {

constexpr size_t kAsked = 200;        // faces whose neighbours are looked for
constexpr double kAlike = 0.05;       // [m] sizes and steps that differ by less are the same
constexpr double kRecurring = 0.2;    // share of the faces that were asked, from which on a step is one of the facade
constexpr double kWidestJoint = 0.3;  // [m] between neighbours

struct Step {
  Eigen::Vector3d shift;
  std::string words;
  int count = 1;
  double border = 0;  ///< faces that have no neighbour there: the outer column or row
};

/// The step to the nearest equal face that follows `from` along axis 0 (right) or 1 (up), if there is one.
bool neighbour_of(const std::vector<PanelFace>& faces, size_t from, int axis, int sign, Eigen::Vector3d& step) {
  const PanelFace& face = faces[from];
  const double size = axis == 0 ? face.width : face.height;
  double nearest = size + kWidestJoint;
  bool found = false;
  for (size_t f = 0; f < faces.size(); ++f) {
    const PanelFace& other = faces[f];
    const Eigen::Vector3d way = face.plane.local(other.plane.origin);
    const double along = sign * way(axis);
    if (f == from || along < 0.5 * size || along > nearest) continue;
    if (std::abs(way(1 - axis)) > kAlike || std::abs(way.z()) > kAlike) continue;
    if (std::abs(other.width - face.width) > kAlike || std::abs(other.height - face.height) > kAlike) continue;
    if (other.plane.axes.col(2).dot(face.plane.axes.col(2)) < 0.98) continue;
    nearest = along, step = other.plane.origin - face.plane.origin, found = true;
  }
  return found;
}

std::vector<Step> recurring_steps(const std::vector<PanelFace>& faces) {
  const char* const directions[2][2] = {{"to the left", "to the right"}, {"down", "up"}};
  const size_t stride = 1 + faces.size() / kAsked;
  std::vector<Step> steps;
  std::vector<Eigen::Vector3d> ends;  // directions in which faces have no neighbour
  int asked = 0;
  for (size_t f = 0; f < faces.size(); f += stride, ++asked)
    for (int axis : {0, 1})
      for (int sign : {-1, 1}) {
        Eigen::Vector3d step;
        if (!neighbour_of(faces, f, axis, sign, step)) {
          ends.push_back(sign * faces[f].plane.axes.col(axis));
          continue;
        }
        const auto known = std::find_if(steps.begin(), steps.end(),
                                        [&](const Step& one) { return (one.shift - step).norm() < kAlike; });
        if (known != steps.end())
          ++known->count;
        else
          steps.push_back({step, fmt::format("{:.2f} m {}", step.norm(), directions[axis][sign > 0])});
      }
  std::erase_if(steps, [&](const Step& step) { return step.count < kRecurring * asked; });
  for (Step& step : steps)
    for (const Eigen::Vector3d& end : ends)
      step.border += end.dot(step.shift.normalized()) > 0.98 ? static_cast<double>(stride) : 0;
  return steps;
}

/// Faces that have points on a quarter of their tiles or more, if all points are moved.
int faces_hit(const ScanTiles& tiles, size_t faces, const std::vector<Eigen::Vector3d>& points,
              const Eigen::Vector3d& shift) {
  std::vector<char> hit(tiles.tiles().size());
  for (const Eigen::Vector3d& point : points)
    if (const auto tile = tiles.tile_of(point + shift)) hit[*tile] = 1;
  std::vector<int> all(faces), with_points(faces);
  for (size_t t = 0; t < hit.size(); ++t) ++all[tiles.tiles()[t].face], with_points[tiles.tiles()[t].face] += hit[t];
  int count = 0;
  for (size_t f = 0; f < faces; ++f) count += with_points[f] > 0 && 4 * with_points[f] >= all[f];
  return count;
}

}  // namespace

ScanPlaces places_of_scan(const std::vector<PanelFace>& faces, const ScanTiles& tiles,
                          const std::vector<Eigen::Vector3d>& points) {
  ScanPlaces places;
  places.panels = faces_hit(tiles, faces.size(), points, Eigen::Vector3d::Zero());
  for (const Step& step : recurring_steps(faces)) {
    const OtherPlace other{step.shift, step.words, faces_hit(tiles, faces.size(), points, step.shift)};
    // A scan that ends with the facade loses the outer column, or gains it; half of that is no accident.
    const double told = std::max(1.0, 0.5 * step.border);
    if (other.panels - places.panels >= told)
      places.better.push_back(other);
    else if (places.panels - other.panels < told)
      places.equal.push_back(other);
  }
  std::stable_sort(places.better.begin(), places.better.end(),
                   [](const OtherPlace& a, const OtherPlace& b) { return a.panels > b.panels; });
  return places;
}

}  // namespace plumbline::surface

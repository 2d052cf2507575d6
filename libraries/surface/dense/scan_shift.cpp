#include "surface/dense/scan_shift.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace plumbline::surface {
namespace {

constexpr size_t kAsked = 200;      // faces whose equal ones are looked for
constexpr size_t kNearest = 24;     // of them
constexpr size_t kSteps = 40;       // that are tried, the most frequent
constexpr double kAlike = 0.05;     // [m] sizes and steps that differ by less are the same
constexpr double kRecurring = 0.2;  // share of the faces that were asked, from which on a step is one of the facade

struct Step {
  Eigen::Vector3d shift;
  std::string words;
  int count = 1;
  double border = 0;  ///< faces that have no equal one there: the outer columns or rows
};

bool equal(const PanelFace& a, const PanelFace& b) {
  return std::abs(a.width - b.width) <= kAlike && std::abs(a.height - b.height) <= kAlike &&
         a.plane.axes.col(2).dot(b.plane.axes.col(2)) >= 0.98 && std::abs(a.plane.local(b.plane.origin).z()) <= kAlike;
}

/// "1.02 m to the left and 2.04 m down".
std::string in_words(const PanelFace& from, const Eigen::Vector3d& step) {
  const char* const directions[2][2] = {{"to the left", "to the right"}, {"down", "up"}};
  std::string text;
  for (int axis : {0, 1}) {
    const double way = from.plane.axes.col(axis).dot(step);
    if (std::abs(way) > kAlike)
      text += (text.empty() ? "" : " and ") + fmt::format("{:.2f} m {}", std::abs(way), directions[axis][way > 0]);
  }
  return text;
}

/// Steps to the nearest equal faces, wherever between others they stand: parapets and windows in turn repeat by
/// storeys.
std::vector<Step> steps_to_equal_faces(const std::vector<PanelFace>& faces, const std::vector<size_t>& asked) {
  std::vector<Step> steps;
  for (const size_t f : asked) {
    std::vector<std::pair<double, Eigen::Vector3d>> others;
    for (size_t g = 0; g < faces.size(); ++g) {
      const Eigen::Vector3d step = faces[g].plane.origin - faces[f].plane.origin;
      if (g != f && step.norm() > kAlike && equal(faces[f], faces[g])) others.emplace_back(step.norm(), step);
    }
    std::stable_sort(others.begin(), others.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    if (others.size() > kNearest) others.resize(kNearest);
    for (const auto& [length, step] : others) {
      const auto known = std::find_if(steps.begin(), steps.end(), [&, &step = step](const Step& one) {
        return (one.shift - step).norm() < kAlike;
      });
      if (known != steps.end())
        ++known->count;
      else
        steps.push_back({step, in_words(faces[f], step)});
    }
  }
  return steps;
}

/// The nearest first.
std::vector<Step> recurring_steps(const std::vector<PanelFace>& faces) {
  const size_t stride = 1 + faces.size() / kAsked;
  std::vector<size_t> asked;
  for (size_t f = 0; f < faces.size(); f += stride) asked.push_back(f);
  std::vector<Step> steps = steps_to_equal_faces(faces, asked);
  std::erase_if(steps, [&](const Step& step) { return step.count < kRecurring * static_cast<double>(asked.size()); });
  std::stable_sort(steps.begin(), steps.end(), [](const Step& a, const Step& b) { return a.count > b.count; });
  if (steps.size() > kSteps) steps.resize(kSteps);
  for (Step& step : steps)
    for (const size_t f : asked) {
      const Eigen::Vector3d there = faces[f].plane.origin + step.shift;
      const bool none = std::none_of(faces.begin(), faces.end(), [&](const PanelFace& other) {
        return (other.plane.origin - there).squaredNorm() < kAlike * kAlike && equal(faces[f], other);
      });
      step.border += none ? static_cast<double>(stride) : 0;
    }
  std::stable_sort(steps.begin(), steps.end(),
                   [](const Step& a, const Step& b) { return a.shift.norm() < b.shift.norm(); });
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

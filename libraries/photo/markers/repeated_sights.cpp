#include "photo/markers/repeated_sights.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <map>
#include <tuple>

#include "geometry/median.hpp"

namespace plumbline::markers {
namespace {

using SightPoints = std::map<std::tuple<double, double, double>, Eigen::Vector2d>;

SightPoints sight_points(const CalibrationView& view) {
  SightPoints points;
  for (const CalibrationPoint& p : view.points)
    points.emplace(std::tuple(p.board.x(), p.board.y(), p.board.z()), p.pixel);
  return points;
}

bool is_same_sight(const SightPoints& a, const SightPoints& b) {
  constexpr double within = 0.5, far = 5, nearly_all = 0.8;  // [px], [px], of the points of the one with fewer
  constexpr size_t fewest = 6;
  std::vector<double> apart;
  for (const auto& [board, pixel] : a) {
    const auto other = b.find(board);
    if (other == b.end()) continue;
    apart.push_back((other->second - pixel).norm());
    if (apart.size() == 1 && apart.front() > far) return false;  // nearly all pairs end here
  }
  return apart.size() >= fewest &&
         static_cast<double>(apart.size()) >= nearly_all * static_cast<double>(std::min(a.size(), b.size())) &&
         median(apart) < within;
}

}  // namespace

std::string repeated_sights(const std::vector<CalibrationView>& views) {
  std::vector<SightPoints> points;
  for (const CalibrationView& view : views) points.push_back(sight_points(view));
  size_t repeated = 0;
  std::string example;
  for (size_t i = 0; i < views.size(); ++i)
    for (size_t j = 0; j < i; ++j) {
      if (!is_same_sight(points[i], points[j])) continue;
      if (repeated++ == 0) example = views[j].path + " and " + views[i].path;
      break;
    }
  if (repeated == 0) return "";
  return fmt::format(
      "{} of the {} photographs {} the board from where another one does, to half a pixel (such as {}): a burst, or "
      "one "
      "photograph saved again. Each counts as if it were taken from elsewhere, and the standard deviations come out "
      "too "
      "small; keep one of each",
      repeated, views.size(), repeated == 1 ? "shows" : "show", example);
}

}  // namespace plumbline::markers

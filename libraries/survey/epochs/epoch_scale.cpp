#include "survey/epochs/epoch_scale.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "geometry/median.hpp"
#include "geometry/thermal_extent.hpp"

namespace plumbline::survey {
namespace {

constexpr double kSmallest = 50e-6, kAgree = 0.1, kShare = 0.8;
constexpr std::size_t kPoints = 4, kMostPoints = 200;  // pairs grow with the square

/// Places of the points that both epochs have, without coordinates that one of them lacks.
std::vector<std::pair<Eigen::Vector3d, Eigen::Vector3d>> common_positions(const Epoch& first, const Epoch& second) {
  std::vector<std::pair<Eigen::Vector3d, Eigen::Vector3d>> points;
  for (std::size_t i = 0; i < first.ids.size() && points.size() < kMostPoints; ++i) {
    const auto at = std::find(second.ids.begin(), second.ids.end(), first.ids[i]);
    if (at == second.ids.end()) continue;
    Eigen::Vector3d a = first.coordinates.segment<3>(static_cast<Eigen::Index>(3 * i));
    Eigen::Vector3d b = second.coordinates.segment<3>(3 * (at - second.ids.begin()));
    for (int k = 0; k < 3; ++k)
      if (!std::isfinite(a[k]) || !std::isfinite(b[k])) a[k] = b[k] = 0;
    points.emplace_back(a, b);
  }
  return points;
}

}  // namespace

std::optional<double> common_scale(const Epoch& first, const Epoch& second) {
  const auto points = common_positions(first, second);
  if (points.size() < kPoints) return std::nullopt;
  std::vector<double> ratios;
  for (std::size_t i = 0; i < points.size(); ++i)
    for (std::size_t j = i + 1; j < points.size(); ++j) {
      const double before = (points[j].first - points[i].first).norm();
      if (before > 0) ratios.push_back((points[j].second - points[i].second).norm() / before);
    }
  if (ratios.empty()) return std::nullopt;
  const double scale = median(ratios), difference = std::abs(scale - 1);
  const auto agreeing =
      std::count_if(ratios.begin(), ratios.end(), [&](double r) { return std::abs(r - scale) <= kAgree * difference; });
  if (!(difference >= kSmallest) || static_cast<double>(agreeing) < kShare * static_cast<double>(ratios.size()))
    return std::nullopt;
  return scale;
}

std::string scale_in_words(double scale) {
  if (std::abs(scale - 1) < kImpossibleScale) {
    return fmt::format("all distances of the second epoch are {:.0f} ppm {} than those of the first",
                       1e6 * std::abs(scale - 1), scale > 1 ? "longer" : "shorter");
  }
  static const std::pair<double, const char*> units[] = {
      {1 / 0.3048, "the second is in feet"},  {0.3048, "the first is in feet"},
      {1000, "the second is in millimetres"}, {0.001, "the first is in millimetres"},
      {100, "the second is in centimetres"},  {0.01, "the first is in centimetres"}};
  std::string words = fmt::format("all distances of the second epoch are {:.6g} times those of the first", scale);
  for (const auto& [factor, unit] : units)
    if (std::abs(scale / factor - 1) < 0.005) words += std::string(": ") + unit;
  return words;
}

std::vector<std::string> size_notes(std::optional<double> scale, const std::vector<Eigen::Vector3d>& places,
                                    const std::vector<Eigen::Vector3d>& sigmas) {
  std::vector<std::string> notes;
  if (scale)
    notes.push_back(scale_in_words(*scale) +
                    ": a ppm setting, a map scale or the temperature was another (10 K make concrete 100 ppm longer); "
                    "the movements hold it");
  std::vector<double> known;
  for (const Eigen::Vector3d& sigma : sigmas)
    for (const double s : sigma)
      if (std::isfinite(s) && s > 0) known.push_back(s);
  const ThermalExtent of = thermal_extent(places);
  const double sigma = median(known);
  constexpr double kToldSigmas = 2;
  if (of.larger() > kToldSigmas * sigma)
    notes.push_back(fmt::format(
        "no epoch says how warm it was: if the points stand on one building, 10 K between two epochs make its {:.1f} m "
        "of height {:.1f} mm longer or shorter, and its {:.1f} m of width {:.1f} mm (concrete, 1e-5 a kelvin by EN "
        "1991-1-5); the median standard deviation of a movement is {:.2f} mm",
        of.height, 1e3 * of.up(), of.width, 1e3 * of.along(), 1e3 * sigma));
  return notes;
}

}  // namespace plumbline::survey

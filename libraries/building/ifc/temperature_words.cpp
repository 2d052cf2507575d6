#include "building/ifc/temperature_words.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/median.hpp"
#include "geometry/thermal_extent.hpp"

namespace plumbline::ifc {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// Of those that are known.
double median_known(std::vector<double> values) {
  std::erase_if(values, [](double value) { return !std::isfinite(value); });
  return median(std::move(values));
}

}  // namespace

std::string temperature_words(const std::vector<Eigen::Vector3d>& places, double tolerance,
                              std::vector<double> sigmas) {
  if (places.empty()) return {};
  const ThermalExtent of = thermal_extent(places);
  const double sigma = median_known(std::move(sigmas)), effect = of.larger();
  if (!(effect > kToldShare * tolerance) && !(effect > kToldSigmas * sigma)) return {};
  std::string text = fmt::format(
      "The model knows no temperature: 10 K make the {:.1f} m of height between these anchors {:.1f} mm longer or "
      "shorter, and their {:.1f} m of width {:.1f} mm (concrete, 1e-5 a kelvin by EN 1991-1-5)",
      of.height, 1e3 * of.up(), of.width, 1e3 * of.along());
  if (std::isfinite(tolerance)) text += fmt::format("; the smallest tolerance is {:.1f} mm", 1e3 * tolerance);
  if (std::isfinite(sigma))
    text += fmt::format("; the median standard deviation of a height is {:.2f} mm", 1e3 * sigma);
  return text;
}

std::string temperature_words(const DeviationT& deviation) {
  std::vector<Eigen::Vector3d> places;
  std::vector<double> sigmas;
  double tolerance = kNone;
  for (const auto& anchor : deviation.anchors) {
    if (!anchor->design.allFinite() || !anchor->deviation.allFinite()) continue;
    places.push_back(anchor->design);
    if (anchor->covariance.size() == 9) sigmas.push_back(std::sqrt(std::max(0.0, anchor->covariance[8])));
    for (const auto& axis : anchor->axes)
      if (axis->tolerance > 0) tolerance = std::fmin(tolerance, axis->tolerance);
  }
  return temperature_words(places, tolerance, std::move(sigmas));
}

std::string temperature_words(const InstallationPlanT& plan) {
  std::vector<Eigen::Vector3d> places;
  std::vector<double> sigmas;
  double tolerance = kNone;
  for (const auto& bracket : plan.brackets)
    if (bracket->measured.allFinite()) places.push_back(bracket->design), sigmas.push_back(bracket->sigma.z());
  for (const auto& length : plan.lengths)
    if (length->high > length->low) tolerance = std::fmin(tolerance, 0.5 * (length->high - length->low));
  return temperature_words(places, tolerance, std::move(sigmas));
}

}  // namespace plumbline::ifc

#include "building/ifc/temperature_words.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "geometry/median.hpp"

namespace plumbline::ifc {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// Of those that are known.
double median_known(std::vector<double> values) {
  std::erase_if(values, [](double value) { return !std::isfinite(value); });
  return median(std::move(values));
}

/// Extent along a direction [m].
double extent(const std::vector<Eigen::Vector3d>& places, const Eigen::Vector3d& direction) {
  double least = std::numeric_limits<double>::infinity(), most = -least;
  for (const Eigen::Vector3d& p : places)
    least = std::min(least, direction.dot(p)), most = std::max(most, direction.dot(p));
  return most - least;
}

/// The longest one in plan, to a thousandth.
double width_of(const std::vector<Eigen::Vector3d>& places) {
  constexpr int kDirections = 36;
  double width = 0;
  for (int i = 0; i < kDirections; ++i) {
    const double angle = std::numbers::pi * i / kDirections;
    width = std::max(width, extent(places, {std::cos(angle), std::sin(angle), 0}));
  }
  return width;
}

}  // namespace

std::string temperature_words(const std::vector<Eigen::Vector3d>& places, double tolerance,
                              std::vector<double> sigmas) {
  if (places.empty()) return {};
  const double height = extent(places, Eigen::Vector3d::UnitZ()), width = width_of(places);
  const double up = 10 * kConcretePerKelvin * height, along = 10 * kConcretePerKelvin * width;
  const double sigma = median_known(std::move(sigmas)), effect = std::max(up, along);
  if (!(effect > kToldShare * tolerance) && !(effect > kToldSigmas * sigma)) return {};
  std::string text = fmt::format(
      "The model knows no temperature: 10 K make the {:.1f} m of height between these anchors {:.1f} mm longer or "
      "shorter, and their {:.1f} m of width {:.1f} mm (concrete, 1e-5 a kelvin by EN 1991-1-5)",
      height, 1e3 * up, width, 1e3 * along);
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

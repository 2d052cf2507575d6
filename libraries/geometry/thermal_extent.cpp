#include "geometry/thermal_extent.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace plumbline {
namespace {

/// Extent of what is known along an axis given by its direction in plan, or up.
template <typename Along>
double extent(const std::vector<Eigen::Vector3d>& places, const Along& along) {
  double least = std::numeric_limits<double>::infinity(), most = -least;
  for (const Eigen::Vector3d& p : places)
    if (const double at = along(p); std::isfinite(at)) least = std::min(least, at), most = std::max(most, at);
  return most >= least ? most - least : 0;
}

}  // namespace

ThermalExtent thermal_extent(const std::vector<Eigen::Vector3d>& places) {
  ThermalExtent found;
  found.height = extent(places, [](const Eigen::Vector3d& p) { return p.z(); });
  constexpr int kDirections = 36;  // the longest to a thousandth
  for (int i = 0; i < kDirections; ++i) {
    const double angle = std::numbers::pi * i / kDirections, c = std::cos(angle), s = std::sin(angle);
    found.width =
        std::max(found.width, extent(places, [&](const Eigen::Vector3d& p) { return c * p.x() + s * p.y(); }));
  }
  return found;
}

}  // namespace plumbline

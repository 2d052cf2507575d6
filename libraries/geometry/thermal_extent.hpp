// What a temperature does to a building: no survey says of itself how warm it was.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace plumbline {

/// Of concrete, a kelvin (EN 1991-1-5, table C.1; steel 12e-6).
inline constexpr double kConcretePerKelvin = 10e-6;

/// Height and greatest width in plan that points [m, z up] span, and what 10 K do to them in concrete [m]. A coordinate
/// that is not finite (a bench mark has a height only) spans nothing.
struct ThermalExtent {
  double height = 0, width = 0;
  double up() const { return 10 * kConcretePerKelvin * height; }
  double along() const { return 10 * kConcretePerKelvin * width; }
  double larger() const { return up() > along() ? up() : along(); }
};
ThermalExtent thermal_extent(const std::vector<Eigen::Vector3d>& places);

}  // namespace plumbline

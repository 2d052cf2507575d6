// A network on a map: what is measured lies on the ground, E and N on a conformal map of the ellipsoid, H above the
// geoid. A line of length s at a height h above the ellipsoid is s k R / (R + h) long on the map, k the map's scale
// there; its image is bent, so that a direction seen differs from that of the straight line (t - T). Both are taken
// from the approximate coordinates: a metre changes the one by some 1e-10, the other by nothing.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "geometry/geodesy/map_projection.hpp"

namespace plumbline::survey {

/// What a map makes of one observation; 1 and 0 without a map.
struct MapCorrection {
  double scale = 1;      ///< horizontal length on the map over that on the ground
  double direction = 0;  ///< t - T of the sight [rad], to be added to what was measured; of an angle: right minus left
};

class MapFrame {
 public:
  /// `system` as geodesy::MapProjection has it; `geoid_height` of the geoid above the ellipsoid [m]. Throws
  /// std::runtime_error.
  MapFrame(const std::string& system, double geoid_height) : map_(system), geoid_height_(geoid_height) {}

  const std::string& name() const { return map_.name(); }
  /// E, N, H of both ends [m]; a NaN height counts as 0.
  double scale(const Eigen::Vector3d& from, const Eigen::Vector3d& to) const;
  double direction(const Eigen::Vector3d& from, const Eigen::Vector3d& to) const {
    return map_.arc_to_chord(from.head<2>(), to.head<2>());
  }
  /// X, Y, Z of the earth at E, N, H [m]; a column of `jacobian` is its derivative by one of these.
  Eigen::Vector3d geocentric(const Eigen::Vector3d& at, Eigen::Matrix3d* jacobian = nullptr) const;
  /// East, north, up there as rows.
  Eigen::Matrix3d horizon(const Eigen::Vector3d& at) const { return map_.horizon(map_.inverse(at.head<2>())); }
  /// Name, scale, convergence and height factor over these points, for people.
  std::string in_words(const std::vector<Eigen::Vector3d>& points) const;

 private:
  double height_factor(const Eigen::Vector2d& at, double height) const;

  geodesy::MapProjection map_;
  double geoid_height_;
};

/// Which well known map would shorten lengths at these places by `factor` [1], in a sentence; empty if none does, or
/// the coordinates are not those of a map. `sigma` of the factor.
std::string map_that_explains(double factor, double sigma, const std::vector<Eigen::Vector3d>& points);

}  // namespace plumbline::survey

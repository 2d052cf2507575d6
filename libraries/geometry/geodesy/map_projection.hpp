// A conformal map of the ellipsoid: where a place lies on it, how much longer or shorter it draws lengths there, and
// how it turns north. EPSG codes and names as PROJ knows them.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>

namespace plumbline::geodesy {

/// A place on the ellipsoid of the map's own datum.
struct Place {
  double latitude = 0, longitude = 0;  ///< [rad], north and east positive
};

/// Of a map at a place.
struct MapFactors {
  double scale = 1;        ///< length on the map over length on the ellipsoid
  double convergence = 0;  ///< azimuth of grid north, clockwise from true north [rad]
};

class MapProjection {
 public:
  /// "EPSG:25832", "utm:32", "utm:19S" (ETRS89 or, south, WGS 84) or a name ("NAD83(CSRS) / New Brunswick
  /// Stereographic"), or a map as PROJ writes it ("+proj=tmerc ... +type=crs"). Of a compound system the horizontal
  /// part. Throws std::runtime_error that says what was found and what is expected: unknown systems, latitudes and
  /// longitudes, axes that are not east and north.
  explicit MapProjection(const std::string& system);
  ~MapProjection();
  MapProjection(const MapProjection&) = delete;
  MapProjection& operator=(const MapProjection&) = delete;

  const std::string& name() const { return name_; }
  /// Whether the map's ellipsoid is that of the earth as satellites see it (GRS80, WGS 84, WGS 72), about the earth's
  /// centre. Bessel's, Clarke's or Airy's lie up to a kilometre beside it, turned and stretched by some ppm.
  bool is_geocentric() const;
  /// East and north [m] to the ellipsoid and back. Throws std::runtime_error where the map does not reach.
  Place inverse(const Eigen::Vector2d& map) const;
  Eigen::Vector2d forward(const Place& place) const;
  /// Scale and convergence at east and north [m]. Throws std::runtime_error where the map is not conformal to 1e-7.
  MapFactors factors(const Eigen::Vector2d& map) const;
  /// Radius of the sphere that fits the ellipsoid there best [m]: the geometric mean of both curvatures.
  double radius(const Place& place) const;
  /// X, Y, Z of the earth, `height` above the ellipsoid [m], and the axes east, north, up there as rows.
  Eigen::Vector3d geocentric(const Place& place, double height) const;
  static Eigen::Matrix3d horizon(const Place& place);
  /// Scale of the map over the line between two places on it (Simpson's rule).
  double line_scale(const Eigen::Vector2d& from, const Eigen::Vector2d& to) const;
  /// t - T [rad]: by how much the straight line on the map leads clockwise of the geodesic's image at `from`, which is
  /// what an instrument sees. To be added to a measured direction to have that of the straight line.
  double arc_to_chord(const Eigen::Vector2d& from, const Eigen::Vector2d& to) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
  std::string name_;
};

}  // namespace plumbline::geodesy

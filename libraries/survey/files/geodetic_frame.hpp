// From latitude and longitude to a plane in which a site's lengths are true, on GRS80.
#pragma once

#include <Eigen/Core>
#include <string>

namespace plumbline::survey {

inline constexpr double kFarthestStation = 500000;  ///< [m] from the middle of a network that is laid on a plane

struct Geodetic {
  double latitude = 0, longitude = 0;  ///< [rad], north and east positive
  double height = 0;                   ///< [m], as given or above the ellipsoid
};

/// Transverse Mercator about a meridian: Krüger's series to the fourth order of the third flattening (better than a
/// micrometre within 3 degrees), with the coefficients of Karney 2011.
class TransverseMercator {
 public:
  TransverseMercator(double central_meridian, double scale) : meridian_(central_meridian), scale_(scale) {}
  Eigen::Vector2d forward(const Geodetic& p) const;      ///< east, north of the equator [m]
  Geodetic inverse(const Eigen::Vector2d& plane) const;  ///< height 0

 private:
  double meridian_, scale_;
};

/// UTM coordinates [m] of a zone 1..60.
Geodetic from_utm(double east, double north, int zone, bool southern);

/// From geocentric coordinates [m]; the height is above the ellipsoid. Bowring's iteration.
Geodetic from_geocentric(const Eigen::Vector3d& p);

/// East and north about `centre`, lengths true at its height.
class GroundPlane {
 public:
  explicit GroundPlane(const Geodetic& centre);
  Eigen::Vector2d operator()(const Geodetic& p) const;
  /// East, north and height above the ellipsoid of geocentric coordinates [m].
  Eigen::Vector3d place(const Eigen::Vector3d& geocentric) const;
  /// What a metre along X, Y, Z there is in east, north and height: columns [m/m].
  Eigen::Matrix3d change(const Eigen::Vector3d& geocentric) const;
  /// The plane as PROJ writes it, so that it can be a map: "+proj=tmerc ...".
  std::string as_map() const;

 private:
  Geodetic centre_;
  double scale_;
  TransverseMercator projection_;
  double north_;
};

}  // namespace plumbline::survey

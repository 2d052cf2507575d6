// A network on a map: what is measured lies on the ground, E and N on a conformal map of the ellipsoid, H above the
// geoid. A line of length s at a height h above the ellipsoid is s k R / (R + h) long on the map, k the map's scale
// there; its image is bent, so that a direction seen differs from that of the straight line (t - T). Both are taken
// from the approximate coordinates: a metre changes the one by some 1e-10, the other by nothing. Instruments stand on
// the plumb line, which the slope of the geoid turns from the ellipsoid's normal: a sight is seen from there, and its
// height difference above the ellipsoid has the geoid's in it (Heiskanen and Moritz, Physical Geodesy, 5-3).
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "geometry/geodesy/geoid.hpp"
#include "geometry/geodesy/map_projection.hpp"

namespace plumbline::survey {

/// What a map makes of one observation; 1 and 0 without a map.
struct MapCorrection {
  double scale = 1;  ///< horizontal length on the map over that on the ground
  /// t - T of the sight and what the deflection of the vertical turns it by [rad], to be added to what was measured; of
  /// an angle: right minus left.
  double direction = 0;
  double zenith = 0;                 ///< likewise, by the deflection: from the plumb line to the normal [rad]
  double rise = 0, second_rise = 0;  ///< of the geoid from station to target(s) [m]
};

/// What is known of the geoid: constants, or the path of a grid in place of `height`.
struct GeoidChoice {
  double height = 0;                                     ///< of the geoid above the map's ellipsoid [m]
  Eigen::Vector2d deflection = Eigen::Vector2d::Zero();  ///< xi, eta [rad]; of a grid its own slope is taken
  /// By how much `height` may rise over the site where it is one constant [rad]: an unknown of the heights of GNSS
  /// vectors with that prior. 0: it is known to be one, or that of an ellipsoid.
  double slope_sigma = 0;
  std::string grid;

  /// Nothing says how it lies beyond one height.
  bool is_open() const { return slope_sigma > 0 && grid.empty() && deflection.isZero(0); }
};

class MapFrame {
 public:
  /// `system` as geodesy::MapProjection has it; `middle` east and north of the site, where the constants of the geoid
  /// hold. Throws std::runtime_error.
  MapFrame(const std::string& system, const GeoidChoice& geoid, const Eigen::Vector2d& middle);

  const std::string& name() const { return map_.name(); }
  bool is_geocentric() const { return map_.is_geocentric(); }
  /// E, N, H of both ends [m]; a NaN height counts as that of the other end, two as 0.
  double scale(const Eigen::Vector3d& from, const Eigen::Vector3d& to) const;
  double direction(const Eigen::Vector3d& from, const Eigen::Vector3d& to) const {
    return map_.arc_to_chord(from.head<2>(), to.head<2>());
  }
  /// What the deflection of the vertical makes of a sight from E, N, H to E, N, H [m], these with the heights of
  /// instrument and target: adds to direction and zenith angle, and gives the geoid's rise [m]. A NaN height counts as
  /// that of the other end.
  void add_deflection(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double& direction, double& zenith,
                      double& rise) const;
  bool has_deflection() const { return geoid_.has_deflection(); }
  double geoid_height(const Eigen::Vector2d& at) const { return geoid_.height(map_.inverse(at)); }
  /// X, Y, Z of the earth at E, N, H [m]; a column of `jacobian` is its derivative by one of these.
  Eigen::Vector3d geocentric(const Eigen::Vector3d& at, Eigen::Matrix3d* jacobian = nullptr) const;
  /// East, north, up there as rows.
  Eigen::Matrix3d horizon(const Eigen::Vector3d& at) const { return map_.horizon(map_.inverse(at.head<2>())); }
  /// Name, scale, convergence and height factor over these points, for people.
  std::string in_words(const std::vector<Eigen::Vector3d>& points) const;

 private:
  double height_factor(const Eigen::Vector2d& at, double height) const;
  std::string geoid_in_words(const Eigen::Vector2d& at) const;

  geodesy::MapProjection map_;
  geodesy::Geoid geoid_;
};

/// Which well known map would shorten lengths at these places by `factor` [1], in a sentence; empty if none does, or
/// the coordinates are not those of a map. `sigma` of the factor.
std::string map_that_explains(double factor, double sigma, const std::vector<Eigen::Vector3d>& points);

}  // namespace plumbline::survey

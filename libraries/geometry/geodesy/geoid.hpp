// How high the geoid lies above the ellipsoid, and how the plumb line stands to the ellipsoid's normal: constants, or a
// grid of geoid heights as PROJ reads it (.gtx, GeoTIFF).
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>

#include "geometry/geodesy/map_projection.hpp"

namespace plumbline::geodesy {

/// A grid of geoid heights. Latitudes and longitudes are those of the grid's own datum; that of the map differs from it
/// by a metre or two at most, in which no geoid changes by more than 0.1 mm.
class GeoidGrid {
 public:
  /// Throws std::runtime_error that names the file: it cannot be read, or is no grid of heights.
  explicit GeoidGrid(const std::string& path);
  ~GeoidGrid();
  GeoidGrid(const GeoidGrid&) = delete;
  GeoidGrid& operator=(const GeoidGrid&) = delete;

  /// [m], between the nodes as PROJ interpolates (bilinear). Throws std::runtime_error outside of the grid.
  double height(const Place& place) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
  std::string path_;
};

/// The geoid of a site. Heights and deflections are one thing: the deflection is the slope of the geoid, so that
/// constants make a plane through `height` at `reference`.
class Geoid {
 public:
  Geoid() = default;
  /// `deflection`: xi, eta [rad], by which the plumb line's zenith lies north and east of the ellipsoid's normal.
  Geoid(double height, const Eigen::Vector2d& deflection, const Place& reference);
  explicit Geoid(std::shared_ptr<const GeoidGrid> grid) : grid_(std::move(grid)) {}

  double height(const Place& place) const;  ///< [m]
  /// xi, eta [rad] at a place: the constants, or minus the slope of the grid over 2 km.
  Eigen::Vector2d deflection(const Place& place) const;
  bool has_deflection() const { return grid_ != nullptr || !deflection_.isZero(0); }

 private:
  std::shared_ptr<const GeoidGrid> grid_;
  double height_ = 0;
  Eigen::Vector2d deflection_ = Eigen::Vector2d::Zero();
  Place reference_;
};

}  // namespace plumbline::geodesy

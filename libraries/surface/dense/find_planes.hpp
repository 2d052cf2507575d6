// Planes in a point cloud of which nobody says where surfaces should be: cells whose neighbourhood is flat grow
// together as long as they lie on one plane. Source: Rabbani, van den Heuvel and Vosselman (2006), Segmentation of
// point clouds using smoothness constraint; on cells instead of points, so that memory goes with what was scanned and
// not with how densely.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <deque>
#include <unordered_map>
#include <vector>

namespace plumbline::surface {

struct PlaneOptions {
  double cell = 0.1;         ///< edge of the cells that points are summed in [m]
  double roughness = 0.006;  ///< rms of the points of a cell and its 26 neighbours about a plane: noise and relief [m]
  double angle = 0.09;       ///< of a cell's plane to that of all [rad]
  double least_area = 1;     ///< of a plane, in cells that have points [m²]
  size_t most_cells = 4'000'000;  ///< that may have points; PlaneFinder::kBytesOfCell each
};

/// A rectangle about the cells of a plane, upright where the plane is.
struct FoundPlane {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  ///< its middle, on the plane [m]
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< to either side
  double width = 0, height = 0;                      ///< along the axes of facade_plane [m]
  double area = 0;                                   ///< of the cells that have points [m²]
  double roughness = 0;                              ///< rms of its points about it [m]
  std::uint64_t points = 0;
};

class PlaneFinder {
 public:
  /// What a cell takes at most, from the first point to the last plane, if all of them lie on one.
  static constexpr size_t kBytesOfCell = 384;

  /// Throws std::invalid_argument for options that are no lengths and angles above zero.
  explicit PlaneFinder(const PlaneOptions& options);
  /// Throws std::length_error if the cloud takes more than PlaneOptions::most_cells.
  void add(const Eigen::Vector3d& point);
  /// The largest first. The order of the points changes nothing but rounding and the order of planes of one size.
  std::vector<FoundPlane> planes() const;

  /// Sums of points about a place.
  struct Sums {
    double count = 0;
    Eigen::Vector3d first = Eigen::Vector3d::Zero();
    Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
    /// Adds those of another place that lies at `apart` from this one.
    void add(const Sums& other, const Eigen::Vector3d& apart);
  };

 private:
  struct Cell {
    Eigen::Matrix<std::int32_t, 3, 1> place;
    Sums sums;  ///< about its middle
  };
  struct Fit;  ///< a plane through sums of points
  static Fit fit_of(const Sums& sums, const Eigen::Vector3d& about);
  std::vector<Fit> fits_of_cells() const;
  /// The cells that lie on one plane with `seed`, which are marked in `plane_of`, and their plane.
  std::vector<size_t> grow(size_t seed, const std::vector<Fit>& local, std::vector<size_t>& plane_of, Fit& all) const;
  FoundPlane outline(const std::vector<size_t>& members, const Fit& all) const;
  std::vector<size_t> around(const Cell& cell) const;  ///< the cells that have points, itself too
  Eigen::Vector3d middle(const Cell& cell) const;
  PlaneOptions options_;
  std::deque<Cell> cells_;  ///< which grows without a copy of all that is there
  std::unordered_map<std::uint64_t, size_t> number_of_;
};

}  // namespace plumbline::surface

// Points of a scan sorted to the faces they lie on, tile by tile, as they come; and what the registration of the scan
// is off by, as the systematic part of each tile.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <optional>
#include <unordered_map>
#include <vector>

#include "plumbline/rigid_transform.hpp"
#include "surface/dense/measured_points.hpp"
#include "surface/dense/panel_surface.hpp"

namespace plumbline::surface {

struct ScanTile {
  size_t face = 0;                                   ///< number of its face
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< on the face [m]
  std::uint64_t points = 0;
};

/// Sorts points to tiles, those of different scans apart. Memory: a buffer a tile and scan, whatever the number of
/// points.
class ScanTiles {
 public:
  /// Takes some points of a tile and a scan, in the order in which they came.
  using Sink = std::function<void(size_t tile, size_t scan, const std::vector<MeasuredPoint>& points)>;
  /// Points belong to a face if they lie over its rectangle, or no more than `beyond` [m] beside it, and within `reach`
  /// [m] of it; of several faces to the one they are nearest to. Tiles are at most `edge` [m] wide and high; those at a
  /// border take what lies beside the face. Throws std::invalid_argument for edges or reaches that are no lengths.
  ScanTiles(const std::vector<PanelFace>& faces, double reach, double edge, Sink sink, double beyond = 0);

  /// Whether the point lies on a face.
  bool add(const Eigen::Vector3d& point, double sigma, size_t scan = 0);
  /// Number of the tile that the point would go to.
  std::optional<size_t> tile_of(const Eigen::Vector3d& point) const;
  void flush();
  const std::vector<ScanTile>& tiles() const { return tiles_; }  ///< also those without points
  size_t scans() const {
    return counts_.size() / std::max<size_t>(1, tiles_.size());
  }  ///< the last one with points, and those before it
  std::uint64_t points_of(size_t tile, size_t scan) const { return counts_[scan * tiles_.size() + tile]; }

 private:
  struct Hit {
    size_t face;
    Eigen::Vector3d local;
  };
  struct Layout {
    size_t first = 0;  ///< tile
    int columns = 1, rows = 1;
  };
  std::optional<Hit> nearest(const Eigen::Vector3d& point) const;
  size_t tile_at(const Hit& hit) const;
  void index(size_t face);

  std::vector<PanelFace> faces_;
  std::vector<Layout> layouts_;
  double reach_, beyond_, cell_ = 1;
  std::unordered_map<std::uint64_t, std::vector<size_t>> faces_by_cell_;
  std::vector<ScanTile> tiles_;
  std::vector<std::vector<MeasuredPoint>> waiting_;  ///< all tiles of the first scan, then of the next
  std::vector<std::uint64_t> counts_;                ///< likewise
  Sink sink_;
};

/// What a scan's place is off by: displacement of a point p = scale_error · (p − pivot) + turn × (p − pivot) + shift,
/// where (turn [rad], shift [m], scale_error [1]) has the covariance.
struct ScanPlace {
  Eigen::Vector3d pivot = Eigen::Vector3d::Zero();
  Eigen::MatrixXd covariance;  ///< 6 x 6 or 7 x 7; empty: nobody knows
};

/// The tile's (t, ω) by independent standard normal numbers, the same for all tiles of the scan: 6 x rank. Of the scale
/// the shift of the whole tile is taken; what it does within a tile is a thousand times less. Throws
/// std::invalid_argument for a covariance of another size or one that is not positive semidefinite.
Eigen::Matrix<double, 6, Eigen::Dynamic> factor_of(const ScanPlace& place, const Eigen::Vector3d& centre);

}  // namespace plumbline::surface

// Heights of a face's cells from pairs of photographs, brought together: facets as dense.plane_sweep gives them,
// whatever found the disparities.
#pragma once

#include <utility>
#include <vector>

#include "surface/dense/facet_tile.hpp"
#include "surface/dense/rectified_pair.hpp"

namespace plumbline::surface {

/// Cells of a face, row by row from below.
struct CellGrid {
  FacadePlane plane;
  Rectangle area;  ///< of the plane [m]
  int columns = 1, rows = 1;
  Eigen::Vector2d step() const { return (area.high - area.low).cwiseQuotient(Eigen::Vector2d(columns, rows)); }
  Eigen::Vector2d middle(size_t cell) const {
    return area.low +
           step().cwiseProduct(Eigen::Vector2d(static_cast<double>(cell % static_cast<size_t>(columns)) + 0.5,
                                               static_cast<double>(cell / static_cast<size_t>(columns)) + 0.5));
  }
  /// Number of the cell that holds a place; nothing beside the area.
  std::optional<size_t> at(double u, double v) const;
  size_t size() const { return static_cast<size_t>(columns) * rows; }
};

/// What one pair says of a cell.
struct PairHeight {
  enum class State : std::uint8_t { not_seen, no_disparity, differs, found } state = State::not_seen;
  double height = 0, sigma = 0;  ///< [m]
};

struct PairOptions {
  double search = 0.05;  ///< [m]
  /// Bring the two photographs together at each cell by least squares (Grün 1985, height alone): disparities of block
  /// matching are drawn towards whole pixels, all of a panel's alike, so that no number of them makes it better.
  bool refine = true;
  double matching_sigma = 0.02;  ///< of a disparity: what its matcher is off by, beside the photographs' noise [px]
  double min_correlation = 0.7;  ///< of what both photographs show of a cell
  double max_sigma = 0.002;      ///< [m]
  int half = 5;                  ///< a cell is compared over (2 · half + 1)² pixels
  int min_views = 3;             ///< photographs that have to agree on a cell
  double min_share = 0.6;        ///< of the pairs that say something of it
};

/// A cell from the heights of the pixels in it: their median, if they are half of it, refined, if the photographs show
/// the same there, and how well what they show fixes a disparity. `expected`: pixels that a full cell has.
PairHeight cell_height(const CellGrid& grid, size_t cell, std::vector<float>& heights, double expected,
                       const RectifiedPair& pair, const std::vector<FacetView>& views, const PairOptions& options);

/// The facet of a cell from all pairs: those that agree with the median, if they are of three photographs or more.
/// `heights`: one a pair.
Facet agreed_facet(const CellGrid& grid, size_t cell, const std::vector<RectifiedPair>& pairs,
                   const std::vector<PairHeight>& heights, const std::vector<FacetView>& views,
                   const PairOptions& options);

}  // namespace plumbline::surface

// Heights in cells, and the gaps under a straightedge that is laid on them.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "surface/dense/panel_surface.hpp"

namespace plumbline::surface {

class HeightGrid {
 public:
  /// `size`: of the rectangle about the origin that the cells divide [m].
  HeightGrid(int columns, int rows, const Eigen::Vector2d& size);

  /// `common`: the systematic error of the height by the cloud's z [m]. Places outside are left out.
  void add(const Eigen::Vector2d& place, double height, double sigma, const Eigen::VectorXd& common);

  /// Cells whose mean is known `times` less surely than the cells' median become empty: of a cell with one point that
  /// is hardly known, that point would be the whole height.
  void leave_out_unsure(double times);

  double coverage() const;  ///< share of the cells that have points

  /// Straightedges along rows, columns and both diagonals, from every cell; the largest gap, and the largest ones of
  /// the cells' errors alone.
  Gap largest_gap(double length) const;

 private:
  struct Cell {
    double weight = 0, height = 0;
    Eigen::Vector2d place = Eigen::Vector2d::Zero();
    Eigen::VectorXd common;
  };
  struct Under;     // a straightedge of some length
  struct Supports;  // and the largest gap under it
  bool lay(int column, int row, int by_column, int by_row, double length, Under& under) const;
  void state(const Under& under, const Supports& at, Gap& gap) const;
  std::vector<std::vector<float>> drawn_errors() const;
  const Cell* filled(int column, int row) const;

  int columns_, rows_;
  Eigen::Vector2d size_;
  std::vector<Cell> cells_;  ///< sums while points are added
};

}  // namespace plumbline::surface

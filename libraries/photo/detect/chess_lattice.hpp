// Whether a lattice of points is the inner corners of a chessboard, and of the whole of it: the corners of its rim are
// easily taken for inner ones, and a part of a board for the board.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

namespace plumbline::detect {

/// Points row by row [px].
struct ChessLattice {
  std::vector<cv::Point2f> corners;
  int columns = 0, rows = 0;
};

/// Whether dark and bright meet crosswise at every point, as at an inner corner and nowhere else. `view`: grey values.
bool is_chessboard(const cv::Mat& view, const ChessLattice& lattice);

/// Adds the rows and columns that the board has around the lattice; true if there are any.
bool grow(const cv::Mat& view, ChessLattice& lattice);

}  // namespace plumbline::detect

// Chessboards in photographs.
#pragma once

#include "photo/detect/board.hpp"

namespace plumbline::detect {

/// Finds the inner corners of a chessboard and measures them in full resolution. A board with more of them than the
/// file says, or with a row, a column or one of each less, is named and not measured.
SeenBoard find_chessboard(const GreyImage& image, const Board& board);

}  // namespace plumbline::detect

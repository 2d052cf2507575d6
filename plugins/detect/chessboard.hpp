// Chessboards in photographs.
#pragma once

#include "detect/board.hpp"

namespace plumbline::detect {

/// Finds the inner corners of a chessboard and measures them in full resolution. A board of one column and one row less
/// is told of: then its squares were counted.
SeenBoard find_chessboard(const GreyImage& image, const Board& board);

}  // namespace plumbline::detect

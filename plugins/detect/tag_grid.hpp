// Grids of tags in photographs.
#pragma once

#include "detect/board.hpp"

namespace plumbline::detect {

/// Finds the tags of a grid and measures their corners. Tags that lie otherwise than the file has them contradict it.
SeenBoard find_tags(const GreyImage& image, const Board& board);

}  // namespace plumbline::detect

// One adjustment of a block of tags, of which marker_to_layout.cpp makes the whole.
#pragma once

#include "photo/markers/marker_block.hpp"

namespace plumbline::markers {

/// Adjusts the block with the layout's places and the calibrations as they are given, blunders left out. Throws
/// std::runtime_error with what the photographs lack.
MarkerResult adjust_as_given(const MarkerBlock& block, const MarkerOptions& options);

}  // namespace plumbline::markers

// The frame and the scale that the result of a free marker network is shown in.
#pragma once

#include "photo/markers/marker_block.hpp"

namespace plumbline::markers {

/// Lengths times what the given distance asks for; with a distance its own uncertainty comes in and the tags' goes out.
/// Throws std::runtime_error if one of its tags could not be placed.
void scale_by_distance(const MarkerBlock& block, const MarkerDistance& distance, MarkerResult& result);

/// Into the frame of the tag with the lowest id; says so in `datum`.
void to_first_tag(const MarkerBlock& block, bool in_one_line, MarkerResult& result);

/// Relative standard deviation of all lengths where the printed size of the tags gives them.
double scale_sigma_by_size(const MarkerBlock& block, const MarkerOptions& options, const MarkerResult& result);

/// What gives the lengths, and how well: `scale_sigma`, and words in `datum`.
void state_scale(const MarkerBlock& block, const MarkerOptions& options, MarkerResult& result);

}  // namespace plumbline::markers

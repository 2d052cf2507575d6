// Whether the cameras of a block of tags are each one camera over all of their photographs.
#pragma once

#include "photo/bundle/adjust.hpp"
#include "photo/markers/marker_block.hpp"
#include "photo/markers/marker_model.hpp"

namespace plumbline::markers {

/// What its photographs say of each camera that is estimated: `truth`, the covariance that this leaves it, warnings;
/// and what that makes of the covariances of tags and photographs (marker_scatter.hpp). `adjusted` is that of the model
/// at its state, `result` has the formal covariances of cameras, tags and photographs.
void judge_cameras(const MarkerBlock& block, const MarkerModel& model, const bundle::Layout& layout,
                   const bundle::Adjusted& adjusted, MarkerResult& result);

/// The block adjusted again with the photographs of a change (camera_changes.hpp) as a camera of their own, in words;
/// empty where camera `c` did not change, or bit by bit, or the block does not adjust.
std::string as_two_cameras(const MarkerBlock& block, const MarkerOptions& options, const MarkerResult& result,
                           std::size_t c);

/// "as two cameras, fx 811.9 ± 0.6 and 852.5 ± 0.7 px, they fit to 0.24 px rms, as one to 0.31 px", the principal
/// distances only where they differ by two standard deviations.
std::string as_two_cameras(const BrownCamera& first, double first_sigma, const BrownCamera& second, double second_sigma,
                           double rms_of_two, double rms_of_one);

}  // namespace plumbline::markers

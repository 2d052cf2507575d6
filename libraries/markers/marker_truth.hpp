// Whether the cameras of a block of tags are each one camera over all of their photographs.
#pragma once

#include "block/block_model.hpp"
#include "markers/marker_block.hpp"
#include "markers/marker_model.hpp"

namespace plumbline::markers {

/// What its photographs say of each camera that is estimated: `truth`, the covariance that this leaves it, warnings.
/// `adjusted` is the block's last linearisation, result.cameras has the formal covariances.
void judge_cameras(const MarkerBlock& block, const MarkerState& state, const MarkerModel& model,
                   const adjust::AdjustedBlock& adjusted, MarkerResult& result);

/// Adjusts the block again with the photographs of each change (camera_changes.hpp) as a camera of their own, and puts
/// into the result and its warnings what that says of the change. A change bit by bit, and a block that does not adjust,
/// stay as they are.
void try_two_cameras(const MarkerBlock& block, const MarkerOptions& options, MarkerResult& result);

/// Takes the scatter of the cameras' photographs out of the warnings and returns it, without a cause: where something
/// else was found to be the cause.
std::string withdraw_scatter(const MarkerBlock& block, MarkerResult& result);

}  // namespace plumbline::markers

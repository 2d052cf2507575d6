// Part of tag_block.cpp: control that contradicts the photographs and the other control.
#pragma once

#include <vector>

#include "photo/block/tag_block.hpp"

namespace plumbline::block {

/// Takes the control of one plate out, with its rows of the covariance.
void leave_out(int plate, TagControl& control);

/// Too many contradictions have another cause than single points: throws std::runtime_error for more than a third.
void require_few(const TagBlock& given, const std::vector<RejectedControl>& rejected);

/// Differences [m] of the survey from the model that the points left out had no part in, and their standard deviations.
void fill_rejected_control(const TagBlock& given, TagBlockResult& result);

/// Names the control that robust_control would leave out, where it stays: a wrong point bends the block and moves its
/// neighbours' w too, so which it is shows only without it.
void name_wrong_control(const TagBlock& given, TagBlockOptions options, TagBlockResult& result);

}  // namespace plumbline::block

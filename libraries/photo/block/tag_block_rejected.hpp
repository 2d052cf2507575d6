// Part of tag_block.cpp: control that contradicts the photographs and the other control.
#pragma once

#include <string>
#include <vector>

#include "photo/block/tag_block.hpp"

namespace plumbline::block {

/// What the tests of the control came to.
struct JudgedControl {
  std::vector<RejectedControl> rejected;
  size_t tested = 0;        ///< points that the photographs show, before any was left out
  std::string doubt;        ///< of control that contradicts and stays all the same, with the reason; else empty
  std::vector<int> hidden;  ///< plates whose control may be off in some direction without that it shows
};

/// Takes the control of one plate out, with its rows of the covariance.
void leave_out(int plate, TagControl& control);

/// Contradictions of more than a third have another cause than single points.
bool are_too_many(size_t tested, const std::vector<RejectedControl>& rejected);

/// Doubts: too many points contradict; without these the rest still contradicts; several explain the same; without this
/// one the rest does not hold the block.
std::string too_many_in_words(const TagBlock& given, size_t tested, const std::vector<RejectedControl>& rejected);
std::string not_mended_in_words(const TagBlock& given, size_t tested, const std::vector<RejectedControl>& rejected);
std::string rivals_in_words(const TagBlock& given, const RejectedControl& worst, const std::vector<int>& rivals);
std::string needed_in_words(const TagBlock& given, const RejectedControl& worst, const std::string& without);

/// Differences [m] of the survey from the model that the points left out had no part in, and their standard deviations;
/// what stays doubtful or untested as warnings.
void fill_judged_control(const TagBlock& given, const JudgedControl& judged, TagBlockResult& result);

/// Names the control that robust_control would leave out, where it stays: a wrong point bends the block and moves its
/// neighbours' w too, so which it is shows only without it.
void name_wrong_control(const TagBlock& given, TagBlockOptions options, TagBlockResult& result);

}  // namespace plumbline::block

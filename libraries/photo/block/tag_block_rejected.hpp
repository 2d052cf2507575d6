// Part of tag_block.cpp: control that contradicts the photographs and the other control.
#pragma once

#include <string>
#include <vector>

#include "photo/block/tag_block.hpp"

namespace plumbline::block {

/// A control point that contradicts and without which the rest does not hold the block.
struct NeededControl {
  RejectedControl worst;
  std::string without;  ///< why the rest does not
};

/// What the tests of the control came to.
struct JudgedControl {
  std::vector<RejectedControl> rejected;
  size_t tested = 0;      ///< points that the photographs show, before any was left out
  bool too_many = false;  ///< more than a third contradict
  std::vector<NeededControl> needed;
  std::vector<ControlDoubt> doubts;    ///< of control that contradicts and stays all the same; not those of `needed`
  std::vector<int> unclear;            ///< plates of which some are wrong, and it does not show which
  std::vector<int> hidden;             ///< plates whose control may be off in some direction without that it shows
  std::vector<std::string> disproved;  ///< groups that fail their own test, and that the search did not believe
};

/// Plates without which the rest does not hold the block.
std::vector<int> plates_of(const std::vector<NeededControl>& needed);

/// Takes the control of one plate out, with its rows of the covariance.
void leave_out(int plate, TagControl& control);

/// Contradictions of more than a third have another cause than single points.
bool are_too_many(size_t tested, const std::vector<RejectedControl>& rejected);

/// Doubts: too many points contradict; without these the rest still contradicts; several explain the same; without this
/// one the rest does not hold the block; this one contradicts only what is disproved itself.
ControlDoubt too_many(const TagBlock& given, size_t tested, const std::vector<RejectedControl>& rejected);
ControlDoubt not_mended(const TagBlock& given, size_t tested, const std::vector<RejectedControl>& rejected);
ControlDoubt rivals(const TagBlock& given, const RejectedControl& worst, const std::vector<int>& others);
ControlDoubt needed(const TagBlock& given, const NeededControl& point);
ControlDoubt as_far_as_believed(const TagBlock& given, const RejectedControl& worst,
                                const std::vector<std::string>& disproved);

/// Differences [m] of the survey from the model that the points left out had no part in, and their standard deviations;
/// what is not tested as a warning.
void fill_judged_control(const TagBlock& given, const JudgedControl& judged, TagBlockResult& result);

/// Names the control that robust_control would leave out, where it stays, as doubts: a wrong point bends the block and
/// moves its neighbours' w too, so which it is shows only without it.
void name_wrong_control(const TagBlock& given, TagBlockOptions options, TagBlockResult& result);

}  // namespace plumbline::block

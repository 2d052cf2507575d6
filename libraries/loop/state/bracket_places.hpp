// Where the anchor of a bracket should be measured, and what explains that it is elsewhere.
#pragma once

#include <string>

#include "artifacts/installation_plan.hpp"
#include "artifacts/loop_state.hpp"

namespace plumbline::loop {

/// What a difference between two measurements must exceed to mean something: the tolerance, or four of its standard
/// deviations, without what campaigns share where the plan tells that. Each axis of the frame [m].
Eigen::Vector3d doubt_of(const BracketSettingT& bracket, double tolerance);

/// Along right, up, out [m].
Eigen::Vector3d along_axes(const BracketSettingT& bracket, const Eigen::Vector3d& v);

/// Where its anchor should be measured now: that a robot was asked does not move it, that it says so does.
Eigen::Vector3d place_of(const LoopItemT& item, const BracketSettingT& bracket);

/// How a robot comes to move a bracket as it did, from where it stood when it was asked; empty if nothing explains it.
std::string explanation(const LoopItemT& item, const BracketSettingT& bracket, double most);

/// Whether the anchor was measured again since the item was reported as done: by another measurement than before, and,
/// if `measured_at` says when (ISO 8601), one that was made after what was done.
bool is_measured_anew(const LoopItemT& item, const BracketSettingT& bracket, const std::string& measured_at);

}  // namespace plumbline::loop

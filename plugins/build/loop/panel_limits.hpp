// What a panel and its joints are held against, as the judgement has it: of a tolerance with two sides both. The
// tolerance beside a judged value says that of the side on which the value lies, and what is planned may lie on the
// other.
#pragma once

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <string>

#include "artifacts/deviation.hpp"
#include "building/ifc/tolerance_source.hpp"
#include "building/judgement/tolerance_request.hpp"
#include "loop/fit/facade.hpp"

namespace plumbline::loop {

/// Null where nothing is asked along that axis.
inline const PanelLimitT* limit_along(const PanelDeviationT& judged, const char* axis) {
  for (const auto& limit : judged.limits)
    if (limit->axis == axis && std::isfinite(limit->above)) return limit.get();
  return nullptr;
}

/// What the corners of a panel may move by along its axes. A length in the plane, or in space, is held by equal parts
/// of it along each of its axes: what keeps these keeps it, and some that would keep it too is not planned.
inline CornerLimits limits_of(const PanelDeviationT& judged) {
  constexpr double kNothingAsked = 1;  // [m]
  CornerLimits limits{judged.sideways->tolerance, judged.vertical->tolerance, judged.out_of_plane->tolerance};
  if (const PanelLimitT* sideways = limit_along(judged, "horizontal"))
    limits.right = limits.out = sideways->above, limits.left = limits.in = sideways->below;
  if (const PanelLimitT* height = limit_along(judged, "vertical"))
    limits.up = height->above, limits.down = height->below;
  if (const PanelLimitT* outward = limit_along(judged, "out_of_plane"))
    limits.out = outward->above, limits.in = outward->below;
  limits.left = limits.back(0), limits.down = limits.back(1), limits.in = limits.back(2);
  const auto narrow = [](std::initializer_list<double*> sides, double to) {
    for (double* side : sides) *side = std::fmin(*side, to);  // of what is not asked (nan): to
  };
  if (const PanelLimitT* length = limit_along(judged, "in_plane"))
    narrow({&limits.right, &limits.left, &limits.up, &limits.down}, length->above / std::sqrt(2.0));
  const PanelLimitT* space = limit_along(judged, "space");
  narrow({&limits.right, &limits.left, &limits.up, &limits.down, &limits.out, &limits.in},
         space ? space->above / std::sqrt(3.0) : kNothingAsked);
  return limits;
}

/// What holds its bottom edge is twisted against its brackets, as judged: the plan knows the middle of that edge alone.
/// Empty: it is not, or nothing is said to hold it.
inline std::string twisted_edge_of(const PanelDeviationT& judged) {
  if (!judged.below || !judged.warp || judged.warp->verdict == ToleranceVerdict::pass ||
      judged.warp->verdict == ToleranceVerdict::not_measured)
    return {};
  return fmt::format(
      "the ends of what holds its bottom edge are off by {:.1f} mm against its brackets, which the plan "
      "does not know: level them, or let somebody look how it sits",
      1e3 * std::abs(judged.warp->value));
}

/// What was asked of panels and could not be judged, where this one may be meant: something of its place is held
/// against what was assumed. Which panels are meant the judgement counts and does not name. What nothing here measures
/// (its flatness) stops no panel from being hung. Empty: nothing.
inline std::string not_judged_of(const DeviationT& deviation, const PanelDeviationT& judged) {
  const bool assumed = !limit_along(judged, "out_of_plane") ||
                       std::any_of(judged.limits.begin(), judged.limits.end(), [](const auto& limit) {
                         return limit->axis != "joint" && ifc::is_default_tolerance(limit->source);
                       });
  for (const auto& request : deviation.requests)
    if (!request->not_judged.empty() && request->not_judged != judgement::kNothingMeasuresIt && request->panels > 0 &&
        judgement::is_property_of_tolerance(request->asked) && assumed)
      return "not judged: " + request->asked + ": " + request->not_judged +
             "; a rule of tolerances for panels says what counts";
  return {};
}

/// How much wider and narrower than by design a joint may be [m].
struct JointLimits {
  double wider = 0, narrower = 0;
};

/// Each panel has its own limits of one joint: it keeps those of both. `other` may be null.
inline JointLimits joint_limits(const PanelDeviationT& judged, const PanelJointT& said, const PanelDeviationT* other) {
  JointLimits limits{said.change->tolerance, said.change->tolerance};
  if (const PanelLimitT* own = limit_along(judged, "joint")) limits = {own->above, own->below};
  if (const PanelLimitT* theirs = other ? limit_along(*other, "joint") : nullptr)
    limits.wider = std::fmin(limits.wider, theirs->above), limits.narrower = std::fmin(limits.narrower, theirs->below);
  return limits;
}

}  // namespace plumbline::loop

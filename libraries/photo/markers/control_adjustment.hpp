// The adjustment of a COLMAP model with its control in the one block model (block/bundle).
#pragma once

#include "photo/markers/control_targets.hpp"

namespace plumbline::markers {

/// Adjusts `model`, which is already in the frame of the control minus result.origin, with `targets` and writes
/// cameras, poses and tie points back into it; fills everything of `result` but its warnings about control. Throws
/// std::runtime_error as bundle::adjust() does.
void adjust_targets(cameras::ColmapModel& model, std::vector<Target> targets, const ControlOptions& options,
                    ControlResult& result);

/// Largest |w| that is no contradiction: 0.1 % for all coordinates of so many control points together (Šidák 1967), not
/// for each.
double critical_w(size_t control_points);

}  // namespace plumbline::markers

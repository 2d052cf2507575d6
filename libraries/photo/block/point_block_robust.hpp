// Control of a block of measured targets that the images and the other control contradict.
#pragma once

#include <string>
#include <vector>

#include "photo/block/control_suspects.hpp"
#include "photo/block/point_block.hpp"

namespace plumbline::block {

/// What suspects_of() finds in an adjusted block, and of which control: its points are indices into `tested`, which are
/// indices into PointBlockResult::control.
struct TestedControl {
  ControlSuspects found;
  std::vector<std::size_t> tested;
};

/// Weighted control by the variance that the images show; nothing is found where the points' joint covariance is not
/// known (above max_joint_points, by_gradients). Coordinates in the frame of the control [m].
TestedControl test_control(const PointBlockResult& result);

/// adjust_point_block() without the control points that contradict, the worst first and one at a time (Baarda 1968), at
/// most a third of them; they are ControlResult::aside then, and what the block says of them without them is their
/// residual. A point that the others explain alike stays, and control_against_images() names all of them. All stay
/// where more would have to go, where the rest would not hold the block, or where the rest still contradicts without a
/// point to blame: then it is no matter of single points. Not by gradients, and not where the weights of the images are
/// what a file states (PointBlockOptions::estimate_image_variance false): all stay. Throws as adjust_point_block().
PointBlockResult adjust_without_wrong_control(const PointBlock& given, const PointBlockOptions& options);

/// A sentence for each control point that was set aside, with what it is off [mm].
std::vector<std::string> set_aside_in_words(const PointBlockResult& result);

}  // namespace plumbline::block

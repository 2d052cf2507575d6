// What an adjustment minimises, computed by somebody else: the cost of given poses, anchors and camera against the
// observations. Whatever made them, start values and results of different programs are compared by the same sum.
#pragma once

#include <map>
#include <string>

#include "block/tag_block.hpp"

namespace plumbline::adjust {

struct TagCost {
  double images = 0;   ///< Σ of the squared whitened corner residuals, by the corners' own covariances
  double control = 0;  ///< of the anchors against the survey, by its covariance
  int corner_rows = 0, control_rows = 0;
  int left_out = 0;  ///< tags whose image has no pose or whose anchor has no coordinates
  double total() const { return images + control; }
};

/// Poses are those of `block.images`, `anchors` the positions by name in the same frame; the camera is the block's.
/// Rotations of the plates, of which anchors say nothing, are those that fit best. No robust loss, no tag left out as a
/// blunder. Throws std::runtime_error if fewer than two images or no anchor take part, or naming the tag that cannot be
/// computed because it lies behind its camera.
TagCost cost_of_tag_block(const TagBlock& block, const std::map<std::string, Eigen::Vector3d>& anchors);

/// The same where every adjustment starts: anchors and plates where the poses put them, images without a pose oriented
/// from plates they share, all of it in the frame of the control. Throws what start_tag_block() and move_to_control()
/// throw, and naming the tag that lies behind its camera.
TagCost start_cost_of_tag_block(const TagBlock& block);

}  // namespace plumbline::adjust

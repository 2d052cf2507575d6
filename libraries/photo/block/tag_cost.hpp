// What an adjustment minimises, computed by somebody else: the cost of given poses, anchors and camera against the
// observations. Whatever made them, start values and results of different programs are compared by the same sum.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "photo/block/tag_block.hpp"

namespace plumbline::block {

struct TagCost {
  double images = 0;   ///< Σ of the squared whitened corner residuals, by the corners' own covariances
  double control = 0;  ///< of the anchors against the survey, by its covariance
  double priors = 0;   ///< of tag sizes, insets, interior orientations and principal points against what is assumed
  int corner_rows = 0, control_rows = 0;
  int left_out = 0;  ///< tags whose image has no pose or whose anchor has no coordinates
  double total() const { return images + control + priors; }
};

/// What is assumed beside the observations; as in TagBlockOptions.
struct TagCostPriors {
  double tag_scale_sigma = 0;              ///< of a print batch's relative tag size; 0: the tags have the printed size
  double corner_inset_sigma = 0;           ///< [px] of how far edges are drawn inwards; 0: they are not
  double image_principal_point_sigma = 0;  ///< [px] of an image's own principal point; 0: it is taken as it is given
  /// Calibration (interior orientation and its covariance) of each of the block's cameras, against which their
  /// interior orientation counts; empty: it does not.
  std::vector<TagCamera> calibration;
  std::vector<std::string> free_interior =
      TagBlockOptions{}.free_interior;  ///< which of its values an adjustment frees
};

/// Poses are those of `block.images`, `anchors` the positions by name in the same frame; the camera is the block's.
/// What these leave open is where it fits best: rotations of the plates, and, under their priors, sizes of the print
/// batches and insets. No robust loss, no tag left out as a blunder: at the minimum that an adjustment without these
/// found, it is that minimum. Throws std::runtime_error if fewer than two images or no anchor take part, or naming the
/// tag that cannot be computed because it lies behind its camera.
TagCost cost_of_tag_block(const TagBlock& block, const std::map<std::string, Eigen::Vector3d>& anchors,
                          const TagCostPriors& priors = {});

/// The same where every adjustment starts: anchors and plates where the poses put them, images without a pose oriented
/// from plates they share, all of it in the frame of the control, tags of the printed size, edges where they are seen.
/// Throws what start_tag_block() and move_to_control() throw, and naming the tag that lies behind its camera.
TagCost start_cost_of_tag_block(const TagBlock& block, const TagCostPriors& priors = {});

}  // namespace plumbline::block

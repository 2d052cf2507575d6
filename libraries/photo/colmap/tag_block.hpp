// A block of marker plates adjusted by COLMAP, and carried to the survey by registration.
//
// What COLMAP adjusts are the tags' corners as single points, all of one weight, and the camera without a prior. What
// it leaves open is done after it, and is no adjustment: the scale from the printed size of the tags; plates by a rigid
// fit to their four corners; with control, a registration (6) of the anchors, by the control's covariance alone,
// because COLMAP gives none. So there is no covariance of anything.
#pragma once

#include "photo/block/tag_block.hpp"
#include "photo/colmap/exchange.hpp"

namespace plumbline::colmap {

struct TagBlockOptions {
  BundleOptions bundle;
  bool estimate_scale = true;     ///< of the registration
  double min_width_ratio = 0.01;  ///< see registration::Options
};

/// Same inputs and approximate values as block::adjust_tag_block(); control that is empty leaves the block where its
/// approximate values are. `result.groups`: "images" with σ of all corners equal to the root of the mean of their given
/// variances; degrees of freedom and σ0 are of the images alone. Every standard deviation, redundancy number, w and MDB
/// is nan, covariances are empty. Plates that one image alone shows are left out: a corner needs two rays.
///
/// Throws std::runtime_error that names the cause: what the images leave undetermined, a block in several parts,
/// control on one line, and what adjust_by_colmap() throws.
block::TagBlockResult adjust_plates(const block::TagBlock& block, const TagBlockOptions& options);

}  // namespace plumbline::colmap

// The joint covariance of all orientations of a block: what a surface that is measured in its photographs needs to
// know.
#pragma once

#include "photo/block/tag_block_model.hpp"
#include "photo/bundle/cofactors.hpp"

namespace plumbline::block {

/// Exterior orientation of one of the model's images, in the world's own origin.
RigidTransform pose_of(const TagModel& model, size_t image);

/// Rotation vector in the camera frame and translation by the unknowns of an image, its projection centre C and a
/// rotation vector δ: t = −exp(δ) R C, so dt = −R dC − [t]× δ.
Matrix6 pose_by_unknowns(const TagModel& model, size_t image);

/// TagBlockResult::orientation_covariance for a variance of unit weight of 1. `images`: what the model's images are in
/// the block.
Eigen::MatrixXd joint_orientations(const std::vector<int>& images, int cameras, const TagModel& model,
                                   const bundle::Layout& layout, const bundle::Cofactors& cofactors);

}  // namespace plumbline::block

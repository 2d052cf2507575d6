// What a pose owes to errors that the tags of an image have in common, which no weight of a single tag holds: the
// camera's calibration, and what the anchors' coordinates share.
#pragma once

#include <Eigen/Core>

#include "geometry/tag_pose.hpp"

namespace plumbline {

struct SharedTagErrors {
  /// Covariance of the camera's parameters, 9 x 9 as InteriorOrientation has them; empty: they are taken as exact.
  Eigen::MatrixXd interior;
  /// Joint covariance of the anchors, 3 x 3 a view in the order of the views [m²]: of one anchor twice where two views
  /// show it. Empty: each view by itself, as its anchor_covariance has it.
  Eigen::MatrixXd anchors;
};

/// The covariance of `pose`, which estimate_tag_pose() made of these views and options, with these errors: of (rotation
/// vector in the camera frame [rad], translation [m]). First order: N⁻¹ of the pose's normal equations says how it
/// follows a tag whose prediction moves, whose weights stay those of the tag alone (generalised least squares with
/// weights that are not the inverse covariance; Koch 1999, 3.2). Throws NoTagPose if a tag lies behind the pose, and
/// std::invalid_argument for sizes that do not fit.
Eigen::Matrix<double, 6, 6> covariance_with(const SharedTagErrors& shared, const BrownCamera& camera,
                                            const std::vector<TagView>& views, const TagPoseOptions& options,
                                            const TagPose& pose);

}  // namespace plumbline

// Exterior orientation of a rig from the tags that all its cameras show at one moment: the scheme of
// geometry/tag_pose.hpp with several projection centres. Cameras that each see one tag, or two, are oriented together.
#pragma once

#include <functional>
#include <vector>

#include "geometry/tag_pose.hpp"

namespace plumbline::pose {

/// One camera of the rig.
struct RigView {
  BrownCamera camera;
  RigidTransform cam_from_rig;
  /// Standard deviation of how far all edges of this photograph are drawn inwards together [px], see TagPoseOptions;
  /// that of the options does not count.
  double inset_sigma = 0;
};

/// A tag, and which camera shows it.
struct RigTag {
  std::size_t view = 0;
  TagView tag;
};

/// Poses rig_from_world that agree with a few tags; none if the solver finds none. May hold wrong ones, too.
using RigPoseSolver =
    std::function<PoseHypotheses(const std::vector<RigView>& views, const std::vector<const RigTag*>& sample)>;

struct RigPose {
  RigidTransform rig_from_world;
  Eigen::Matrix<double, 6, 6> covariance;  ///< of (rotation vector in the rig's frame [rad], translation [m])
  std::vector<bool> inliers;               ///< for each tag
  int inlier_count = 0;                    ///< tags
};

/// Throws NoTagPose, also for fewer tags than a sample has. The rig itself counts as free of error. Same input, same
/// bits.
RigPose estimate_rig_pose(const std::vector<RigView>& views, const std::vector<RigTag>& tags,
                          const RigPoseSolver& solver, const TagPoseOptions& options);

/// Root mean square of the inliers' corners in one camera, per coordinate [px]; nan if it shows none.
double rms_in_view(const std::vector<RigView>& views, const std::vector<RigTag>& tags, const RigPose& pose,
                   std::size_t view, double plate_rotation_sigma);

}  // namespace plumbline::pose

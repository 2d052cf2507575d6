// What a solver alone makes of a few tags, without the search, the refinement and the covariance that all initialisers
// have in common: to tell solvers apart. In the common frame they cannot be: it ends at the same minimum from wherever
// they let it start (60 of 60 trials agree to 1e-11).
#pragma once

#include "geometry/tag_pose.hpp"

namespace plumbline::pose {

/// The pose of `solver` from the `tags` tags that are largest in the image. Of several hypotheses the one with the
/// smallest sum of squared reprojection errors of those tags' corners: that is how one of the two poses of a tag is
/// chosen when nothing else is known. rms is that of these corners, covariance is zero. Throws NoTagPose if there are
/// too few tags or the solver finds nothing.
TagPose raw_tag_pose(const BrownCamera& camera, const std::vector<TagView>& views, const TagPoseSolver& solver,
                     int tags);

}  // namespace plumbline::pose

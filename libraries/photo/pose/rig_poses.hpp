// From the artifacts of a pose initialiser to rig_pose.hpp: photographs of a rig, moment by moment.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "photo/pose/pose_node.hpp"
#include "photo/pose/rig.hpp"
#include "photo/pose/rig_pose.hpp"

namespace plumbline::pose {

/// Poses of the photographs that show a tag of the table, in their order. A moment needs `settings.min_markers` tags
/// over all its photographs. `central` solves for one camera, in the search for why tags do not agree. `warn` is told
/// of moments that are left out. Throws std::runtime_error that names the photographs of a moment, what was found in
/// them and what to do.
PosesT initial_rig_poses(const std::vector<ImageTagsT>& images, const CameraT& camera, const Rig& rig,
                         const PlatesT& plates, const PointsT& points, const RigPoseSolver& solver,
                         const TagPoseSolver& central, const PoseSettings& settings,
                         const std::function<void(const std::string&)>& warn);

}  // namespace plumbline::pose

// What a robot's knowledge of its own place does to what it sets: from the pose of its camera by the tags it sees.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "artifacts/poses.hpp"

namespace plumbline::loop {

/// Covariance of where something stands that a robot places at `point` by its own pose [m², frame of the poses].
/// First order of point = cam_from_world^-1(seen): J C J', J = R' [-[R point]x, I], with the covariance C of (rotation
/// vector in the camera frame, translation), R <- exp(rotation) R. Throws std::runtime_error that names a pose without
/// covariance.
Eigen::Matrix3d station_covariance(const PoseT& pose, const Eigen::Vector3d& point);

/// The same of several places at once, each by the station that is nearest to it: 3 x 3 for each, in their order. Two
/// places of one robot share its error; of two robots what their poses share by PosesT::joint_covariance, and nothing
/// where that is empty. Throws as station_covariance(), and for a joint covariance of another size than the poses have.
Eigen::MatrixXd station_covariances(const PosesT& stations, const std::vector<Eigen::Vector3d>& places);

/// Where it then really stands less where it should: of a robot that believes `believed` and is at `true_pose` [m].
Eigen::Vector3d station_error(const RigidTransform& believed, const RigidTransform& true_pose,
                              const Eigen::Vector3d& point);

/// The station that is nearest to a point. Throws std::runtime_error if there is none.
const PoseT& nearest_station(const PosesT& stations, const Eigen::Vector3d& point);

}  // namespace plumbline::loop

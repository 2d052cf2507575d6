#include "loop/gate/station_error.hpp"

#include <algorithm>
#include <stdexcept>

#include "geometry/packed_symmetric.hpp"

namespace plumbline::loop {

Eigen::Matrix3d station_covariance(const PoseT& pose, const Eigen::Vector3d& point) {
  if (pose.covariance.empty())
    throw std::runtime_error("the station of " + pose.path +
                             " has no covariance: how well its robot knows where it is nobody can tell; take a node "
                             "that states it, such as adjust.schur behind the pose node");
  const Eigen::MatrixXd covariance = unpack_symmetric(pose.covariance, 6, "the station of " + pose.path);
  const Eigen::Matrix3d turn = pose.cam_from_world.rotation.toRotationMatrix();
  Eigen::Matrix<double, 3, 6> of_pose;
  of_pose << -skew(turn * point), Eigen::Matrix3d::Identity();
  of_pose = (turn.transpose() * of_pose).eval();
  return of_pose * covariance * of_pose.transpose();
}

Eigen::Vector3d station_error(const RigidTransform& believed, const RigidTransform& true_pose,
                              const Eigen::Vector3d& point) {
  return true_pose.inverse() * (believed * point) - point;
}

const PoseT& nearest_station(const PosesT& stations, const Eigen::Vector3d& point) {
  const auto distance = [&](const auto& pose) { return (pose->cam_from_world.inverse().translation - point).norm(); };
  const auto found = std::min_element(stations.poses.begin(), stations.poses.end(),
                                      [&](const auto& a, const auto& b) { return distance(a) < distance(b); });
  if (found == stations.poses.end()) throw std::runtime_error("no robot knows where it stands: 'stations' is empty");
  return **found;
}

}  // namespace plumbline::loop

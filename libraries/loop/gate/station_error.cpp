#include "loop/gate/station_error.hpp"

#include <algorithm>
#include <stdexcept>

#include "geometry/packed_symmetric.hpp"

namespace plumbline::loop {

namespace {

/// d(point)/d(pose) of a point that a robot places by its pose, 3 x 6.
Eigen::Matrix<double, 3, 6> by_pose(const PoseT& pose, const Eigen::Vector3d& point) {
  const Eigen::Matrix3d turn = pose.cam_from_world.rotation.toRotationMatrix();
  Eigen::Matrix<double, 3, 6> rows;
  rows << -skew(turn * point), Eigen::Matrix3d::Identity();
  return turn.transpose() * rows;
}

Eigen::MatrixXd own_covariance(const PoseT& pose) {
  if (pose.covariance.empty())
    throw std::runtime_error("the station of " + pose.path +
                             " has no covariance: how well its robot knows where it is nobody can tell; take a node "
                             "that states it, such as adjust.schur behind the pose node");
  return unpack_symmetric(pose.covariance, 6, "the station of " + pose.path);
}

/// Of all poses, 6 x 6 each: jointly where it is known.
Eigen::MatrixXd covariance_of(const PosesT& stations) {
  constexpr Eigen::Index own = 8, camera = 9;  // unknowns of an image, with its principal point, and of a camera
  const auto n = static_cast<Eigen::Index>(stations.poses.size());
  Eigen::MatrixXd all = Eigen::MatrixXd::Zero(6 * n, 6 * n);
  if (stations.joint_covariance.empty()) {
    for (Eigen::Index i = 0; i < n; ++i) all.block<6, 6>(6 * i, 6 * i) = own_covariance(*stations.poses[i]);
    return all;
  }
  const Eigen::Index size = own * n + camera * static_cast<Eigen::Index>(stations.cameras.size());
  const Eigen::MatrixXd joint =
      unpack_symmetric(stations.joint_covariance, static_cast<std::size_t>(size), "the stations together");
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j) all.block<6, 6>(6 * i, 6 * j) = joint.block<6, 6>(own * i, own * j);
  return all;
}

std::size_t nearest(const PosesT& stations, const Eigen::Vector3d& point) {
  const auto distance = [&](const auto& pose) { return (pose->cam_from_world.inverse().translation - point).norm(); };
  const auto found = std::min_element(stations.poses.begin(), stations.poses.end(),
                                      [&](const auto& a, const auto& b) { return distance(a) < distance(b); });
  if (found == stations.poses.end()) throw std::runtime_error("no robot knows where it stands: 'stations' is empty");
  return static_cast<std::size_t>(found - stations.poses.begin());
}

}  // namespace

Eigen::Matrix3d station_covariance(const PoseT& pose, const Eigen::Vector3d& point) {
  const Eigen::MatrixXd covariance = own_covariance(pose);
  const auto rows = by_pose(pose, point);
  return rows * covariance * rows.transpose();
}

Eigen::MatrixXd station_covariances(const PosesT& stations, const std::vector<Eigen::Vector3d>& places) {
  const Eigen::MatrixXd poses = covariance_of(stations);
  const auto n = static_cast<Eigen::Index>(places.size());
  std::vector<Eigen::Index> by;
  std::vector<Eigen::Matrix<double, 3, 6>> rows;
  for (const Eigen::Vector3d& place : places) {
    by.push_back(static_cast<Eigen::Index>(nearest(stations, place)));
    rows.push_back(by_pose(*stations.poses[by.back()], place));
  }
  Eigen::MatrixXd out(3 * n, 3 * n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j)
      out.block<3, 3>(3 * i, 3 * j) = rows[i] * poses.block<6, 6>(6 * by[i], 6 * by[j]) * rows[j].transpose();
  return out;
}

Eigen::Vector3d station_error(const RigidTransform& believed, const RigidTransform& true_pose,
                              const Eigen::Vector3d& point) {
  return true_pose.inverse() * (believed * point) - point;
}

const PoseT& nearest_station(const PosesT& stations, const Eigen::Vector3d& point) {
  return *stations.poses[nearest(stations, point)];
}

}  // namespace plumbline::loop

// How the cameras of a rig stand to each other, from photographs of one board taken at the same moments.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "plumbline/rigid_transform.hpp"

namespace plumbline::markers {

/// One camera's view of the board.
struct RigView {
  std::string moment;  ///< equal for photographs taken together
  RigidTransform cam_from_board;
};

struct RigPose {
  int camera = 0, reference = 0;  ///< indices into the given cameras
  RigidTransform cam_from_reference;
  Eigen::Vector3d rotation_sigma = Eigen::Vector3d::Zero();     ///< of the mean, from the scatter [rad]
  Eigen::Vector3d translation_sigma = Eigen::Vector3d::Zero();  ///< [m]
  double rotation_scatter = 0, translation_scatter = 0;         ///< rms of one moment against the mean [rad], [m]
  std::vector<std::string> moments;                             ///< those that took part
  std::vector<std::string> left_out;  ///< those in which the cameras do not stand as in the others
};

/// Each camera against the earlier one that it shares most moments with: mean over the moments, without those that lie
/// more than five times the median off. Standard deviations hold what scatters from moment to moment, not what an error
/// of the interior orientations does to all of them. Cameras that share fewer than three moments have no entry.
std::vector<RigPose> rig_of(const std::vector<std::vector<RigView>>& cameras);

}  // namespace plumbline::markers

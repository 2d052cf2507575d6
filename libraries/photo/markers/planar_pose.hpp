// The pose of a camera before a plane figure of known size, and the second pose that fits nearly as well.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "plumbline/rigid_transform.hpp"

namespace plumbline::markers {

/// A pose and how well it fits: root mean square of the residuals, per coordinate, in normalised image coordinates.
struct FittedPose {
  RigidTransform cam_from_figure;
  double rms = 0;
};

/// Both poses of a square tag, the better one first; one if the other lies behind the camera, none if the corners are
/// no image of a square. Corners as in tag_corners_in_plate(), in normalised image coordinates (free of distortion);
/// `size` is the edge [m]. Source: Collins & Bartoli (2014), Infinitesimal plane-based pose estimation; each solution
/// is then refined by Gauss-Newton on its own.
std::vector<FittedPose> poses_of_square(const std::array<Eigen::Vector2d, 4>& corners, double size);

/// Least-squares pose from `start`: normalised image coordinates of points of the figure [m]. `weights` (one a point,
/// may be empty) multiply the squares. Levenberg-Marquardt; returns the best pose found.
FittedPose refine_pose(const RigidTransform& start, const std::vector<Eigen::Vector3d>& figure,
                       const std::vector<Eigen::Vector2d>& image, const std::vector<double>& weights = {});

/// Homography that maps plane points to the image, by the direct linear transformation with normalised coordinates
/// (Hartley & Zisserman 2004, 4.1). Precondition: at least four points, not three of four on one line.
Eigen::Matrix3d plane_homography(const std::vector<Eigen::Vector2d>& plane, const std::vector<Eigen::Vector2d>& image);

/// Poses of a plane figure (z = 0) from at least four of its points, by the same method as poses_of_square().
std::vector<FittedPose> poses_of_plane(const std::vector<Eigen::Vector2d>& figure,
                                       const std::vector<Eigen::Vector2d>& image);

}  // namespace plumbline::markers

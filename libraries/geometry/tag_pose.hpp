// Exterior orientation of an image from the fiducial tags in it, when the tags' places are known only approximately and
// some of the tags are not the ones they are taken for.
//
// The unit that is right or wrong is the tag, not the corner: its four corners share the error of its anchor's
// approximate coordinates and of its plate's nominal rotation. Both are part of the stochastic model (the rotation to
// the second order, because a plate that is turned looks smaller whichever way it is turned), and so is that plates are
// bent and tags no perfect squares, so how far a tag may be
// off in the image follows from what is said of the field, for every depth and focal length, and no threshold in pixels
// has to be chosen. Scheme: minimal samples of tags go to a solver (given by the caller), each hypothesis is scored by
// a slowly growing function of the Mahalanobis distances of all tags, the best are refined on their inliers (Chum et
// al. 2003, LO-RANSAC), and the last solution is a generalised least-squares fit with its covariance.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <functional>
#include <stdexcept>
#include <vector>

#include "geometry/camera.hpp"
#include "plumbline/failure.hpp"
#include "plumbline/rigid_transform.hpp"

namespace plumbline {

/// One tag in one image: where it is in the image and, nominally, in the world. Corners in the order bottom left,
/// bottom right, top right, top left.
struct TagView {
  int id = 0;
  double tag_size = 0;                    ///< [m]
  RigidTransform world_from_tag;          ///< tag frame: origin at its centre, x right, y up, z out of it
  Eigen::Vector3d anchor_in_world;        ///< about which the plate is turned against its nominal rotation [m]
  Eigen::Matrix3d anchor_covariance;      ///< of the approximate coordinates [m²]
  std::array<Eigen::Vector2d, 4> pixels;  ///< [px]
  std::array<Eigen::Matrix2d, 4> pixel_covariances;  ///< [px²]
  std::array<Eigen::Vector3d, 4> bearings;           ///< unit vectors in the camera frame, free of distortion

  Eigen::Vector3d corner_in_tag(int i) const {
    const double h = 0.5 * tag_size;
    return {i == 1 || i == 2 ? h : -h, i >= 2 ? h : -h, 0};
  }
  Eigen::Vector3d corner_in_world(int i) const { return world_from_tag * corner_in_tag(i); }
};

/// Poses cam_from_world that agree with a few tags; none if the solver finds none. May hold wrong ones, too.
using PoseHypotheses = std::vector<RigidTransform>;
using TagPoseSolver = std::function<PoseHypotheses(const std::vector<const TagView*>& sample)>;

struct TagPoseOptions {
  int sample_size = 3;                  ///< tags a sample
  int max_samples = 200;                ///< at most; fewer once enough of them hold right tags only
  double plate_rotation_sigma = 0.035;  ///< of a plate against its nominal rotation, about each axis [rad]
  double tag_shape_sigma = 0;           ///< of a corner against the plane square, each axis, relative to tag_size [1]
  /// Standard deviation of how far all edges of the image are drawn inwards together [px]: all tags look smaller by it,
  /// so the camera stands further off. In the covariance alone; it is small beside what separates right tags from
  /// wrong.
  double inset_sigma = 0;
  double inlier_probability = 0.999;  ///< of a right tag to be taken as one (chi-squared with 8 degrees of freedom)
  std::uint64_t seed = 1;             ///< of the samples
};

struct TagPose {
  RigidTransform cam_from_world;
  /// Of (rotation vector in the camera frame [rad], translation [m]).
  Eigen::Matrix<double, 6, 6> covariance;
  std::vector<bool> inliers;  ///< for each view
  int inlier_count = 0;       ///< tags
  double rms = 0;  ///< of the inliers' corners, per coordinate [px]; holds the error of the approximate coordinates
};

/// No pose agrees with three tags. The text says how far the best one came.
class NoTagPose : public BadInput {
 public:
  using BadInput::BadInput;
};

/// Throws NoTagPose, also for fewer views than a sample needs. Same input, same bits.
TagPose estimate_tag_pose(const BrownCamera& camera, const std::vector<TagView>& views, const TagPoseSolver& solver,
                          const TagPoseOptions& options);

}  // namespace plumbline

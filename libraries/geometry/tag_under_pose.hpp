// One tag under a pose: where its corners should be, how uncertain that is, and what it adds to normal equations. The
// inner part of tag_pose.hpp. The four corners of a tag lie side by side, so that a vector of the processor holds all.
#pragma once

#include <Eigen/Core>
#include <array>

#include "geometry/tag_pose.hpp"

namespace plumbline {

/// One number of each corner.
using OfCorners = std::array<double, 4>;

/// Measured minus predicted corners [px], and what their derivatives are made of.
struct ProjectedTag {
  std::array<OfCorners, 2> residuals;  ///< x, y
  std::array<OfCorners, 3> rotated;    ///< corners in the camera frame, without its translation [m]
  std::array<OfCorners, 6> by_point;   ///< of x, then of y, by the corner in the camera frame [px/m]
  double sum_of_squares() const;       ///< of the residuals [px²]
};

/// A pose with its rotation as a matrix.
struct MatrixPose {
  explicit MatrixPose(const RigidTransform& cam_from_world)
      : rotation(cam_from_world.rotation.toRotationMatrix()), translation(cam_from_world.translation) {}
  Eigen::Matrix3d rotation;
  Eigen::Vector3d translation;
};

/// Covariance of a tag's residuals, x of all corners before y of all, column by column. Of y by x above the diagonal
/// nothing is read or written.
using TagCovariance = std::array<std::array<double, 8>, 8>;

/// Factors L D Lᵀ of the covariance of a tag's residuals; L has a unit diagonal.
struct TagWeight {
  /// False if it is not positive definite.
  bool compute(const TagCovariance& covariance);
  /// Mahalanobis distance squared.
  double distance(const ProjectedTag& tag) const;

  TagCovariance lower;                   ///< L below its diagonal, zero elsewhere
  std::array<double, 8> inverse_pivots;  ///< D⁻¹
};

/// Normal equations of a pose (rotation vector in the camera frame, translation) and the sum of squares.
struct PoseEquations {
  /// The last column belongs to nothing: eight numbers a row are whole vectors of any processor.
  Eigen::Matrix<double, 8, 8, Eigen::RowMajor> sums = Eigen::Matrix<double, 8, 8, Eigen::RowMajor>::Zero();
  void add(const ProjectedTag& tag, const TagWeight& weight);
  Eigen::Matrix<double, 6, 6> normal() const { return sums.topLeftCorner<6, 6>(); }
  Eigen::Matrix<double, 6, 1> right() const { return sums.col(6).head<6>(); }
  double sum_of_squares() const { return sums(6, 6); }
};

/// What of a tag's prediction is the same for all poses: where its corners are in the world, made smaller as a plate
/// that is turned one way or the other looks, and the covariance of all four by the anchor and the turn of the plate.
class TagInWorld {
 public:
  TagInWorld(const TagView& view, const TagPoseOptions& options);

  /// False if a corner falls behind the camera.
  bool project(const BrownCamera& camera, const MatrixPose& pose, ProjectedTag& tag) const;
  /// Of the residuals: corners, anchor and plate rotation together.
  void covariance(const MatrixPose& pose, const ProjectedTag& tag, TagCovariance& result) const;
  /// Mahalanobis distance squared of the corners; infinite behind the camera.
  double distance(const BrownCamera& camera, const MatrixPose& pose) const;

  /// As they are read: see above. `spread[j]` is, row by row, the covariance of all corners with corner j [m²].
  struct Numbers {
    std::array<OfCorners, 2> pixels;
    std::array<OfCorners, 3> pixel_covariances;  ///< xx, xy, yy
    std::array<OfCorners, 3> corners;            ///< [m]
    std::array<std::array<OfCorners, 9>, 4> spread;
  };

 private:
  Numbers numbers_;
};

}  // namespace plumbline

// One tag under a pose: where its corners should be, how uncertain that is, and what it adds to normal equations. The
// inner part of tag_pose.hpp; everything has a fixed size and the rows of a tag lie side by side.
#pragma once

#include <Eigen/Core>
#include <array>

#include "geometry/tag_pose.hpp"

namespace plumbline {

using TagResiduals = Eigen::Matrix<double, 8, 1>;

/// Measured minus predicted corners [px], and what their derivatives are made of.
struct ProjectedTag {
  TagResiduals residuals;
  std::array<Eigen::Vector3d, 4> rotated;               ///< corners in the camera frame, without its translation [m]
  std::array<Eigen::Matrix<double, 2, 3>, 4> by_point;  ///< of the pixel by the corner in the camera frame [px/m]
};

/// A pose with its rotation as a matrix.
struct MatrixPose {
  explicit MatrixPose(const RigidTransform& cam_from_world)
      : rotation(cam_from_world.rotation.toRotationMatrix()), translation(cam_from_world.translation) {}
  Eigen::Matrix3d rotation;
  Eigen::Vector3d translation;
};

struct PoseEquations;

/// Factor of the covariance of a tag's residuals.
class TagWeight {
 public:
  /// Takes the lower triangle; false if it is not positive definite.
  bool compute(const Eigen::Matrix<double, 8, 8>& covariance);

  /// L⁻¹ rows, in place.
  template <typename Rows>
  void whiten(Rows& rows) const {
    for (int r = 0; r < 8; ++r) {
      for (int k = 0; k < r; ++k) rows.row(r) -= lower_(r, k) * rows.row(k);
      rows.row(r) *= inverse_(r);
    }
  }

 private:
  friend struct PoseEquations;
  Eigen::Matrix<double, 8, 8, Eigen::RowMajor> lower_;  ///< L below its diagonal
  Eigen::Matrix<double, 8, 1> inverse_;                 ///< of the diagonal
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
  TagInWorld(const TagView& view, double plate_rotation_sigma);

  /// False if a corner falls behind the camera.
  bool project(const BrownCamera& camera, const MatrixPose& pose, ProjectedTag& tag) const;
  /// Of the residuals: corners, anchor and plate rotation together; its lower triangle.
  Eigen::Matrix<double, 8, 8> covariance(const MatrixPose& pose, const ProjectedTag& tag) const;
  /// Mahalanobis distance squared of the corners; infinite behind the camera.
  double distance(const BrownCamera& camera, const MatrixPose& pose) const;

 private:
  std::array<Eigen::Vector2d, 4> pixels_;
  std::array<Eigen::Matrix2d, 4> pixel_covariances_;
  std::array<Eigen::Vector3d, 4> corners_;                // [m]
  std::array<std::array<Eigen::Matrix3d, 4>, 4> spread_;  // of corners i and j ≤ i [m²]
};

}  // namespace plumbline

#include "geometry/tag_pose_errors.hpp"

#include <Eigen/Cholesky>
#include <cmath>

#include "geometry/tag_under_pose.hpp"
#include "geometry/vectors.hpp"

namespace plumbline {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// Adds one tag with the weight that belongs to the pose.
void add(const BrownCamera& camera, const TagView& view, const TagPoseOptions& options, const MatrixPose& pose,
         PoseEquations& equations) {
  const TagInWorld world(view, options);
  ProjectedTag tag;
  TagCovariance spread;
  TagWeight weight;
  if (!world.project(camera, pose, tag)) throw NoTagPose("the pose leads behind a tag");
  world.covariance(pose, tag, spread);
  if (!weight.compute(spread)) throw NoTagPose("a tag has no positive definite covariance");
  equations.add(tag, weight);
}

/// Right sides of the equations of all inliers.
Vector6 right_side(const BrownCamera& camera, const std::vector<TagView>& views, const std::vector<bool>& inliers,
                   const TagPoseOptions& options, const MatrixPose& pose) {
  PoseEquations equations;
  for (std::size_t i = 0; i < views.size(); ++i)
    if (inliers[i]) add(camera, views[i], options, pose, equations);
  return equations.right();
}

/// By each parameter, for a displacement by its standard deviation.
Eigen::Matrix<double, 6, Eigen::Dynamic> by_interior(const Eigen::VectorXd& sigma, const BrownCamera& camera,
                                                     const std::vector<TagView>& views,
                                                     const std::vector<bool>& inliers, const TagPoseOptions& options,
                                                     const MatrixPose& pose) {
  const Vector6 here = right_side(camera, views, inliers, options, pose);
  Eigen::Matrix<double, 6, Eigen::Dynamic> columns = Eigen::MatrixXd::Zero(6, sigma.size());
  for (Eigen::Index p = 0; p < sigma.size(); ++p) {
    if (!(sigma[p] > 0)) continue;
    auto values = camera.parameters();
    values[p] += sigma[p];
    BrownCamera displaced = camera;
    displaced.set_parameters(values);
    columns.col(p) = right_side(displaced, views, inliers, options, pose) - here;
  }
  return columns;
}

/// By each coordinate of each view's anchor [1/m]; of views that are no inliers zero.
Eigen::Matrix<double, 6, Eigen::Dynamic> by_anchors(const BrownCamera& camera, const std::vector<TagView>& views,
                                                    const std::vector<bool>& inliers, const TagPoseOptions& options,
                                                    const MatrixPose& pose) {
  constexpr double step = 1e-5;  // [m]
  Eigen::Matrix<double, 6, Eigen::Dynamic> columns =
      Eigen::MatrixXd::Zero(6, 3 * static_cast<Eigen::Index>(views.size()));
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (!inliers[i]) continue;
    PoseEquations here;
    add(camera, views[i], options, pose, here);
    for (int k = 0; k < 3; ++k) {
      TagView displaced = views[i];
      displaced.anchor_in_world[k] += step, displaced.world_from_tag.translation[k] += step;
      PoseEquations there;
      add(camera, displaced, options, pose, there);
      columns.col(3 * static_cast<Eigen::Index>(i) + k) = (there.right() - here.right()) / step;
    }
  }
  return columns;
}

}  // namespace

Eigen::Matrix<double, 6, 6> covariance_with(const SharedTagErrors& shared, const BrownCamera& camera,
                                            const std::vector<TagView>& views, const TagPoseOptions& options,
                                            const TagPose& pose) {
  const auto n = 3 * static_cast<Eigen::Index>(views.size());
  if (pose.inliers.size() != views.size() || (shared.anchors.size() > 0 && shared.anchors.rows() != n) ||
      (shared.interior.size() > 0 && shared.interior.rows() != InteriorOrientation::parameter_count))
    throw std::invalid_argument("views, inliers and covariances of shared errors do not fit each other");
  // About the tags: a rotation about the origin of national coordinates could not be told from a translation.
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (const TagView& view : views) centre += view.anchor_in_world / static_cast<double>(views.size());
  std::vector<TagView> local = views;
  for (TagView& view : local) view.anchor_in_world -= centre, view.world_from_tag.translation -= centre;
  const Eigen::Vector3d shift = pose.cam_from_world.rotation * centre;
  const MatrixPose at(RigidTransform{pose.cam_from_world.rotation, pose.cam_from_world.translation + shift});

  PoseEquations equations;
  for (std::size_t i = 0; i < local.size(); ++i)
    if (pose.inliers[i]) add(camera, local[i], options, at, equations);
  Matrix6 sides = Matrix6::Zero();  // covariance of the right sides, of what is shared alone
  if (shared.interior.size() > 0) {
    const Eigen::VectorXd sigma = shared.interior.diagonal().cwiseMax(0).cwiseSqrt();
    const Eigen::VectorXd inverse = sigma.unaryExpr([](double s) { return s > 0 ? 1 / s : 0.0; });
    const auto columns = by_interior(sigma, camera, local, pose.inliers, options, at);
    sides += columns * (inverse.asDiagonal() * shared.interior * inverse.asDiagonal()) * columns.transpose();
  }
  if (shared.anchors.size() > 0) {
    Eigen::MatrixXd more = shared.anchors;  // than the views' own, which their weights have
    for (std::size_t i = 0; i < local.size(); ++i) {
      const auto row = 3 * static_cast<Eigen::Index>(i);
      more.block<3, 3>(row, row) -= local[i].anchor_covariance;
    }
    const auto columns = by_anchors(camera, local, pose.inliers, options, at);
    sides += columns * more * columns.transpose();
  }
  const Matrix6 inverse = equations.normal().ldlt().solve(Matrix6::Identity());
  Matrix6 step_from_local = Matrix6::Identity();
  step_from_local.bottomLeftCorner<3, 3>() = skew(shift);
  const Matrix6 total = pose.covariance + step_from_local * inverse * sides * inverse * step_from_local.transpose();
  return 0.5 * (total + total.transpose());
}

}  // namespace plumbline

// pose.@name@: orients photographs by their tags, and stands in for pose.opengv (poses.use=pose.@name@).
//
// Write your solver into solve(). What all solvers have in common (which tags may be used, mistaken ones, what is said
// of an image that cannot be oriented) is PoseNode's.
#include <Eigen/SVD>

#include "geometry/linear_algebra/decompositions.hpp"
#include "photo/pose/pose_node.hpp"

using namespace plumbline;

namespace {

/// From the four corners of each tag in the world [m] and their bearings in the camera frame (unit vectors):
/// cam_from_world, or several where the tags leave a choice. Here: the homography between the plane that fits the
/// corners best and the bearings (Zhang 2000).
PoseHypotheses solve(const std::vector<const TagView*>& sample) {
  const auto n = static_cast<Eigen::Index>(4 * sample.size());
  Eigen::Matrix3Xd points(3, n), bearings(3, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const TagView& tag = *sample[static_cast<size_t>(i / 4)];
    points.col(i) = tag.corner_in_world(static_cast<int>(i % 4));
    bearings.col(i) = tag.bearings[static_cast<size_t>(i % 4)];
  }
  const Eigen::Vector3d centre = points.rowwise().mean();
  const Eigen::Matrix3Xd centred = points.colwise() - centre;
  Eigen::Matrix3d axes = linear_algebra::SingularValues(centred, Eigen::ComputeFullU).matrixU();
  if (axes.determinant() < 0) axes.col(2) *= -1;
  const Eigen::Matrix3Xd plane = axes.transpose() * centred;
  Eigen::MatrixXd rows(2 * n, 9);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::RowVector3d p(plane(0, i), plane(1, i), 1), none(0, 0, 0);
    const Eigen::Vector3d b = bearings.col(i);
    rows.row(2 * i) << b.z() * p, none, -b.x() * p;
    rows.row(2 * i + 1) << none, b.z() * p, -b.y() * p;
  }
  const Eigen::VectorXd h = linear_algebra::SingularValues(rows, Eigen::ComputeFullV).matrixV().col(8);
  Eigen::Matrix3d m = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(h.data());
  m /= (m(2, 2) < 0 ? -1 : 1) * std::sqrt(m.col(0).norm() * m.col(1).norm());
  const Eigen::Vector3d translation = m.col(2);
  m.col(2) = m.col(0).cross(m.col(1));
  const Eigen::JacobiSVD<Eigen::Matrix3d> nearest(m, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Matrix3d rotation = nearest.matrixU() * nearest.matrixV().transpose() * axes.transpose();
  return {{Eigen::Quaterniond(rotation), translation - rotation * centre}};
}

struct Solver : pose::PoseNode {
  static constexpr Info info{"pose.@name@", "pose_initialiser", 1, "Orients images by the plane of their tags"};
  void run(Context& context) override { run_with(context, solve); }
};

}  // namespace

PLUMBLINE_PLUGIN("@name@", "0.1.0", "MIT", Solver)

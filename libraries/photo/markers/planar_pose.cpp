#include "photo/markers/planar_pose.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/linear_algebra/decompositions.hpp"
#include "geometry/similarity.hpp"

namespace plumbline::markers {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

/// Scales and shifts points to mean 0 and mean distance √2.
Eigen::Matrix3d normalisation(const std::vector<Eigen::Vector2d>& points) {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const auto& p : points) mean += p / static_cast<double>(points.size());
  double distance = 0;
  for (const auto& p : points) distance += (p - mean).norm() / static_cast<double>(points.size());
  const double scale = distance > 0 ? std::sqrt(2.0) / distance : 1.0;
  Eigen::Matrix3d m;
  m << scale, 0, -scale * mean.x(), 0, scale, -scale * mean.y(), 0, 0, 1;
  return m;
}

/// Weighted sum of squared residuals; infinite if a point lies behind the camera.
double cost_of(const RigidTransform& pose, const std::vector<Eigen::Vector3d>& figure,
               const std::vector<Eigen::Vector2d>& image, const std::vector<double>& weights) {
  double cost = 0;
  for (size_t i = 0; i < figure.size(); ++i) {
    const Eigen::Vector3d p = pose * figure[i];
    if (!(p.z() > 1e-9)) return std::numeric_limits<double>::infinity();
    cost += (weights.empty() ? 1.0 : weights[i]) * (p.hnormalized() - image[i]).squaredNorm();
  }
  return cost;
}

/// Translation that goes with a rotation, linear least squares: the image ray of each point is met.
Eigen::Vector3d translation_for(const Eigen::Matrix3d& rotation, const std::vector<Eigen::Vector3d>& figure,
                                const std::vector<Eigen::Vector2d>& image) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (size_t i = 0; i < figure.size(); ++i) {
    Eigen::Matrix<double, 2, 3> rows;
    rows << 1, 0, -image[i].x(), 0, 1, -image[i].y();
    normal += rows.transpose() * rows;
    right -= rows.transpose() * rows * (rotation * figure[i]);
  }
  return normal.ldlt().solve(right);
}

/// The two rotations that agree with a homography to first order at the figure's origin (Collins & Bartoli 2014).
std::vector<Eigen::Matrix3d> rotations_of(const Eigen::Matrix3d& homography) {
  const Eigen::Matrix3d h = homography / homography(2, 2);
  const Eigen::Vector2d v(h(0, 2), h(1, 2));
  Eigen::Matrix2d slope;
  slope << h(0, 0) - h(2, 0) * v.x(), h(0, 1) - h(2, 1) * v.x(), h(1, 0) - h(2, 0) * v.y(), h(1, 1) - h(2, 1) * v.y();
  const Eigen::Matrix3d turn = shortest_rotation(Eigen::Vector3d::UnitZ(), v.homogeneous()).toRotationMatrix();
  Eigen::Matrix<double, 2, 3> sight;
  sight << 1, 0, -v.x(), 0, 1, -v.y();
  const Eigen::Matrix2d a = (sight * turn).leftCols<2>().inverse() * slope;
  const Eigen::Matrix2d aa = a * a.transpose();
  const double gamma = std::sqrt(0.5 * (aa.trace() + std::hypot(aa(0, 0) - aa(1, 1), 2 * aa(0, 1))));
  if (!(gamma > 1e-12) || !a.allFinite()) return {};
  const Eigen::Matrix2d upper = a / gamma;
  const double b0 = std::sqrt(std::max(0.0, 1 - upper.col(0).squaredNorm()));
  double b1 = std::sqrt(std::max(0.0, 1 - upper.col(1).squaredNorm()));
  if (upper.col(0).dot(upper.col(1)) > 0) b1 = -b1;
  std::vector<Eigen::Matrix3d> rotations;
  for (const double sign : {1.0, -1.0}) {
    Eigen::Matrix3d r;
    r.col(0) << upper(0, 0), upper(1, 0), sign * b0;
    r.col(1) << upper(0, 1), upper(1, 1), sign * b1;
    r.col(2) = r.col(0).cross(r.col(1));
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(turn * r, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Eigen::Matrix3d nearest = svd.matrixU() * svd.matrixV().transpose();
    if (nearest.determinant() > 0) rotations.push_back(nearest);
  }
  return rotations;
}

}  // namespace

Eigen::Matrix3d plane_homography(const std::vector<Eigen::Vector2d>& plane, const std::vector<Eigen::Vector2d>& image) {
  const Eigen::Matrix3d from = normalisation(plane), to = normalisation(image);
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(2 * static_cast<Eigen::Index>(plane.size()), 9);
  for (size_t i = 0; i < plane.size(); ++i) {
    const Eigen::Vector3d p = from * plane[i].homogeneous();
    const Eigen::Vector3d q = to * image[i].homogeneous();
    const Eigen::Index r = 2 * static_cast<Eigen::Index>(i);
    rows.row(r) << p.transpose(), 0, 0, 0, -q.x() * p.transpose();
    rows.row(r + 1) << 0, 0, 0, p.transpose(), -q.y() * p.transpose();
  }
  const linear_algebra::SingularValues svd(rows, Eigen::ComputeFullV);
  const Eigen::VectorXd h = svd.matrixV().col(8);
  Eigen::Matrix3d m;
  m << h(0), h(1), h(2), h(3), h(4), h(5), h(6), h(7), h(8);
  m = to.inverse() * m * from;
  return m / (std::abs(m(2, 2)) > 1e-12 ? m(2, 2) : m.norm());
}

FittedPose refine_pose(const RigidTransform& start, const std::vector<Eigen::Vector3d>& figure,
                       const std::vector<Eigen::Vector2d>& image, const std::vector<double>& weights) {
  constexpr int max_iterations = 30;
  FittedPose best{start, 0};
  double cost = cost_of(start, figure, image, weights), damping = 1e-4;
  for (int iteration = 0; iteration < max_iterations && std::isfinite(cost); ++iteration) {
    Matrix6 normal = Matrix6::Zero();
    Vector6 right = Vector6::Zero();
    for (size_t i = 0; i < figure.size(); ++i) {
      const Eigen::Vector3d turned = best.cam_from_figure.rotation * figure[i],
                            p = turned + best.cam_from_figure.translation;
      Eigen::Matrix<double, 2, 3> by_point;
      by_point << 1 / p.z(), 0, -p.x() / (p.z() * p.z()), 0, 1 / p.z(), -p.y() / (p.z() * p.z());
      Eigen::Matrix<double, 2, 6> rows;
      rows << by_point * -skew(turned), by_point;
      const double weight = weights.empty() ? 1.0 : weights[i];
      normal += weight * rows.transpose() * rows;
      right += weight * rows.transpose() * (image[i] - p.hnormalized());
    }
    Matrix6 damped = normal;
    damped.diagonal() *= 1 + damping;
    const Vector6 step = damped.ldlt().solve(right);
    RigidTransform next = best.cam_from_figure;
    next.rotation = (quaternion_from_rotation_vector(step.head<3>()) * next.rotation).normalized();
    next.translation += step.tail<3>();
    const double next_cost = step.allFinite() ? cost_of(next, figure, image, weights) : cost;
    if (!(next_cost < cost)) {
      damping *= 10;
      if (damping > 1e6) break;
      continue;
    }
    const bool converged = cost - next_cost < 1e-12 * cost;
    best.cam_from_figure = next, cost = next_cost, damping = std::max(1e-12, 0.1 * damping);
    if (converged) break;
  }
  best.rms = std::sqrt(cost / (2.0 * static_cast<double>(figure.size())));
  return best;
}

std::vector<FittedPose> poses_of_plane(const std::vector<Eigen::Vector2d>& figure,
                                       const std::vector<Eigen::Vector2d>& image) {
  std::vector<FittedPose> poses;
  // The method looks at the neighbourhood of the origin, so that has to lie within the figure.
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  for (const auto& p : figure) middle += p / static_cast<double>(figure.size());
  std::vector<Eigen::Vector2d> centred;
  std::vector<Eigen::Vector3d> points, shifted;
  for (const auto& p : figure) {
    centred.push_back(p - middle);
    points.emplace_back(p.x(), p.y(), 0);
    shifted.emplace_back(p.x() - middle.x(), p.y() - middle.y(), 0);
  }
  for (const Eigen::Matrix3d& rotation : rotations_of(plane_homography(centred, image))) {
    const Eigen::Vector3d translation = translation_for(rotation, shifted, image);
    RigidTransform start{Eigen::Quaterniond(rotation),
                         translation - rotation * Eigen::Vector3d(middle.x(), middle.y(), 0)};
    const FittedPose fitted = refine_pose(start, points, image);
    if (std::isfinite(fitted.rms)) poses.push_back(fitted);
  }
  std::stable_sort(poses.begin(), poses.end(), [](const auto& a, const auto& b) { return a.rms < b.rms; });
  if (poses.size() == 2) {
    const double turn = poses[0].cam_from_figure.rotation.angularDistance(poses[1].cam_from_figure.rotation);
    if (turn < 1e-4) poses.pop_back();
  }
  return poses;
}

std::vector<FittedPose> poses_of_square(const std::array<Eigen::Vector2d, 4>& corners, double size) {
  const double h = 0.5 * size;
  return poses_of_plane({{-h, -h}, {h, -h}, {h, h}, {-h, h}}, {corners.begin(), corners.end()});
}

}  // namespace plumbline::markers

#include "geometry/triangulation.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "geometry/linear_algebra/decompositions.hpp"

namespace plumbline {
namespace {

constexpr double parallel = 1e-12;  ///< of the smallest against the largest eigenvalue of the equations

struct Ray {
  Eigen::Vector3d origin, direction;  ///< of unit length
};

std::vector<Ray> rays_of(const std::vector<PointView>& views) {
  std::vector<Ray> rays;
  for (const auto& view : views) {
    const Eigen::Quaterniond world_from_cam = view.cam_from_world.rotation.conjugate();
    rays.push_back({-(world_from_cam * view.cam_from_world.translation),
                    (world_from_cam * view.normalised.homogeneous()).normalized()});
  }
  return rays;
}

std::optional<Eigen::Vector3d> midpoint_of(const std::vector<Ray>& rays) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const auto& ray : rays) {
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - ray.direction * ray.direction.transpose();
    normal += across;
    right += across * (ray.origin - rays[0].origin);
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> spectrum(normal);
  if (!(spectrum.eigenvalues()(0) > parallel * spectrum.eigenvalues()(2))) return std::nullopt;
  return rays[0].origin + normal.ldlt().solve(right);
}

/// `about` only conditions the equations.
std::optional<Eigen::Vector3d> linear_solution(const std::vector<PointView>& views, const std::vector<Ray>& rays,
                                               const Eigen::Vector3d& about) {
  double scale = 0;
  for (const auto& ray : rays) scale = std::max(scale, (ray.origin - about).norm());
  Eigen::MatrixX4d equations(2 * static_cast<Eigen::Index>(views.size()), 4);
  for (size_t i = 0; i < views.size(); ++i) {
    Eigen::Matrix<double, 3, 4> projection;
    projection.leftCols<3>() = scale * views[i].cam_from_world.rotation.toRotationMatrix();
    projection.col(3) = views[i].cam_from_world * about;
    for (Eigen::Index c = 0; c < 2; ++c)
      equations.row(2 * static_cast<Eigen::Index>(i) + c) =
          views[i].normalised(c) * projection.row(2) - projection.row(c);
  }
  const linear_algebra::SingularValues svd(equations, Eigen::ComputeFullV);
  const Eigen::Vector4d x = svd.matrixV().col(3);
  if (!(std::abs(x(3)) > parallel)) return std::nullopt;
  return Eigen::Vector3d(about + scale * x.head<3>() / x(3));
}

double sum_of_chords(const std::vector<Ray>& rays, const Eigen::Vector3d& point) {
  double sum = 0;
  for (const auto& ray : rays) sum += ((point - ray.origin).normalized() - ray.direction).squaredNorm();
  return sum;
}

Eigen::Vector3d least_angles(const std::vector<Ray>& rays, Eigen::Vector3d point) {
  double cost = sum_of_chords(rays, point);
  for (int iteration = 0; iteration < 50; ++iteration) {
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (const auto& ray : rays) {
      const Eigen::Vector3d away = point - ray.origin, u = away.normalized();
      const Eigen::Matrix3d slope = (Eigen::Matrix3d::Identity() - u * u.transpose()) / away.norm();
      normal += slope * slope;
      right -= slope * (u - ray.direction);
    }
    Eigen::Vector3d step = normal.ldlt().solve(right);
    double next = sum_of_chords(rays, point + step);
    for (int half = 0; half < 20 && !(next <= cost); ++half) next = sum_of_chords(rays, point + (step *= 0.5));
    if (!(next <= cost)) break;
    point += step;
    cost = next;
    if (step.norm() < 1e-14 * (point - rays[0].origin).norm()) break;
  }
  return point;
}

}  // namespace

std::optional<Triangulated> triangulate(const std::vector<PointView>& views, Triangulation method) {
  if (views.size() < 2) return std::nullopt;
  const std::vector<Ray> rays = rays_of(views);
  const auto in_front = [&](const Eigen::Vector3d& p) {
    return std::all_of(views.begin(), views.end(), [&](const PointView& v) { return (v.cam_from_world * p).z() > 0; });
  };
  std::optional<Eigen::Vector3d> point = midpoint_of(rays);
  if (point && !in_front(*point)) return std::nullopt;
  if (point && method == Triangulation::dlt) point = linear_solution(views, rays, *point);
  if (point && method == Triangulation::angular) point = least_angles(rays, *point);
  if (!point || !point->allFinite() || !in_front(*point)) return std::nullopt;
  Triangulated result;
  result.point = *point;
  for (size_t i = 0; i < rays.size(); ++i) {
    const Eigen::Vector3d away = *point - rays[i].origin;
    result.rms_angle += std::pow(std::atan2(away.cross(rays[i].direction).norm(), away.dot(rays[i].direction)), 2);
    for (size_t k = 0; k < i; ++k) {
      const Eigen::Vector3d &a = rays[i].direction, &b = rays[k].direction;
      result.parallax = std::max(result.parallax, std::atan2(a.cross(b).norm(), a.dot(b)));
    }
  }
  result.rms_angle = std::sqrt(result.rms_angle / static_cast<double>(rays.size()));
  return result;
}

}  // namespace plumbline

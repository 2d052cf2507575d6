#include "geometry/camera.hpp"

#include <Eigen/LU>
#include <cmath>

namespace plumbline {

std::optional<Eigen::Vector2d> project(const BrownCamera& camera, const Eigen::Vector3d& point_in_camera) {
  if (!(point_in_camera.z() > 0)) return std::nullopt;
  const auto parameters = camera.parameters();
  Eigen::Vector2d pixel;
  project_normalised(parameters.data(), point_in_camera.x() / point_in_camera.z(),
                     point_in_camera.y() / point_in_camera.z(), pixel.data());
  return pixel;
}

namespace {

/// Value and Jacobian of the distortion map on normalised coordinates.
void distort(const BrownCamera& c, const Eigen::Vector2d& p, Eigen::Vector2d& value, Eigen::Matrix2d& jacobian) {
  const double x = p.x(), y = p.y(), r2 = x * x + y * y;
  const double radial = 1 + r2 * (c.k1 + r2 * (c.k2 + r2 * c.k3));
  const double slope = 2 * (c.k1 + r2 * (2 * c.k2 + 3 * r2 * c.k3));  // d radial / d x = slope · x
  value << x * radial + 2 * c.p1 * x * y + c.p2 * (r2 + 2 * x * x),
      y * radial + c.p1 * (r2 + 2 * y * y) + 2 * c.p2 * x * y;
  jacobian(0, 0) = radial + slope * x * x + 2 * c.p1 * y + 6 * c.p2 * x;
  jacobian(0, 1) = jacobian(1, 0) = slope * x * y + 2 * c.p1 * x + 2 * c.p2 * y;
  jacobian(1, 1) = radial + slope * y * y + 6 * c.p1 * y + 2 * c.p2 * x;
}

}  // namespace

std::optional<ProjectionWithSlope> project_with_slope(const BrownCamera& camera,
                                                      const Eigen::Vector3d& point_in_camera) {
  const double z = point_in_camera.z();
  if (!(z > 0)) return std::nullopt;
  const Eigen::Vector2d normalised = point_in_camera.head<2>() / z;
  Eigen::Vector2d distorted;
  Eigen::Matrix2d slope;
  distort(camera, normalised, distorted, slope);
  Eigen::Matrix<double, 2, 3> by_point;
  by_point << 1 / z, 0, -normalised.x() / z, 0, 1 / z, -normalised.y() / z;
  const Eigen::Vector2d focal(camera.fx, camera.fy);
  return ProjectionWithSlope{focal.cwiseProduct(distorted) + Eigen::Vector2d(camera.cx, camera.cy),
                             focal.asDiagonal() * slope * by_point};
}

std::optional<Eigen::Vector2d> unproject(const BrownCamera& camera, const Eigen::Vector2d& pixel) {
  const Eigen::Vector2d target((pixel.x() - camera.cx) / camera.fx, (pixel.y() - camera.cy) / camera.fy);
  Eigen::Vector2d p = target;
  for (int iteration = 0; iteration < 50; ++iteration) {
    Eigen::Vector2d value;
    Eigen::Matrix2d jacobian;
    distort(camera, p, value, jacobian);
    // A determinant that is not positive means that the radial polynomial has turned back: no inverse out here.
    if (!(jacobian.determinant() > 1e-9)) return std::nullopt;
    const Eigen::Vector2d step = jacobian.inverse() * (target - value);
    p += step;
    if (!p.allFinite()) return std::nullopt;
    if (step.norm() < 1e-13) return p;
  }
  return std::nullopt;
}

}  // namespace plumbline

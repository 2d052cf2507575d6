#include "geometry/camera.hpp"

#include <Eigen/LU>
#include <cmath>

#include "geometry/lens_distortion.hpp"

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

Eigen::Matrix2d derivatives(const Distorted<double>& d) {
  Eigen::Matrix2d matrix;
  matrix << d.by_xx, d.by_xy, d.by_xy, d.by_yy;
  return matrix;
}

}  // namespace

std::optional<ProjectionWithSlope> project_with_slope(const BrownCamera& camera,
                                                      const Eigen::Vector3d& point_in_camera) {
  const double z = point_in_camera.z();
  if (!(z > 0)) return std::nullopt;
  const Eigen::Vector2d normalised = point_in_camera.head<2>() / z;
  Distorted<double> d;
  distort(camera, normalised.x(), normalised.y(), d);
  const Eigen::Vector2d distorted(d.x, d.y);
  const Eigen::Matrix2d slope = derivatives(d);
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
    Distorted<double> d;
    distort(camera, p.x(), p.y(), d);
    const Eigen::Vector2d value(d.x, d.y);
    const Eigen::Matrix2d jacobian = derivatives(d);
    // A determinant that is not positive means that the radial polynomial has turned back: no inverse out here.
    if (!(jacobian.determinant() > 1e-9)) return std::nullopt;
    const Eigen::Vector2d step = jacobian.inverse() * (target - value);
    p += step;
    if (!p.allFinite()) return std::nullopt;
    if (step.norm() < 1e-8) return p;  // steps square the error: what is left is rounding
  }
  return std::nullopt;
}

}  // namespace plumbline

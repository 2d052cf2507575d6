#include "geometry/camera.hpp"

#include <Eigen/LU>
#include <cmath>
#include <numbers>

#include "geometry/lens_distortion.hpp"

namespace plumbline {

std::string_view name_of(LensModel lens) { return lens == LensModel::fisheye ? "fisheye" : "brown"; }

std::optional<LensModel> lens_called(std::string_view name) {
  for (const LensModel lens : {LensModel::brown, LensModel::fisheye})
    if (name == name_of(lens)) return lens;
  return std::nullopt;
}

std::span<const char* const> InteriorOrientation::names_of(LensModel lens) {
  static constexpr std::array<const char*, 9> brown = {"fx", "fy", "cx", "cy", "k1", "k2", "k3", "p1", "p2"};
  static constexpr std::array<const char*, 8> fisheye = {"fx", "fy", "cx", "cy", "k1", "k2", "k3", "k4"};
  if (lens == LensModel::fisheye) return fisheye;
  return brown;
}

std::optional<Eigen::Vector2d> project(const InteriorOrientation& camera, const Eigen::Vector3d& point_in_camera) {
  if (!(point_in_camera.z() > 0)) return std::nullopt;
  Distorted<double> d;
  distort(camera, point_in_camera.x() / point_in_camera.z(), point_in_camera.y() / point_in_camera.z(), d);
  return Eigen::Vector2d(camera.fx * d.x + camera.cx, camera.fy * d.y + camera.cy);
}

namespace {

Eigen::Matrix2d derivatives(const Distorted<double>& d) {
  Eigen::Matrix2d matrix;
  matrix << d.by_xx, d.by_xy, d.by_xy, d.by_yy;
  return matrix;
}

/// θ (1 + k1 θ² + ...) = drawn; nothing where the polynomial has turned back before it is reached, or at 90°.
std::optional<double> fisheye_angle(const InteriorOrientation& c, double drawn) {
  constexpr double widest = 0.5 * std::numbers::pi - 1e-4;
  constexpr int pieces = 24;
  const auto value = [&](double a) {
    const double a2 = a * a;
    return a * (1 + a2 * (c.k1 + a2 * (c.k2 + a2 * (c.k3 + a2 * c.k4))));
  };
  double low = 0, high = widest;
  for (int k = 1; k <= pieces; ++k) {
    const double end = widest * k / pieces;
    if (!(value(end) > value(low))) return std::nullopt;
    high = end;
    if (value(end) >= drawn) break;
    low = end;
  }
  if (!(value(high) >= drawn)) return std::nullopt;
  double angle = 0.5 * (low + high);
  for (int iteration = 0; iteration < 60; ++iteration) {
    const double a2 = angle * angle, off = value(angle) - drawn;
    (off > 0 ? high : low) = angle;
    const double slope = 1 + a2 * (3 * c.k1 + a2 * (5 * c.k2 + a2 * (7 * c.k3 + a2 * 9 * c.k4)));
    double next = angle - off / slope;
    if (!(next > low && next < high)) next = 0.5 * (low + high);
    const double step = std::abs(next - angle);
    angle = next;
    if (step < 1e-15) break;
  }
  return angle;
}

}  // namespace

std::optional<ProjectionWithSlope> project_with_slope(const InteriorOrientation& camera,
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

Eigen::Matrix<double, 2, InteriorOrientation::parameter_count> pixel_by_parameters(const InteriorOrientation& camera,
                                                                                   double x, double y) {
  Eigen::Matrix<double, 2, InteriorOrientation::parameter_count> slope;
  Distorted<double> d;
  distort(camera, x, y, d);
  slope.leftCols<4>() << d.x, 0, 1, 0, 0, d.y, 0, 1;
  const double r2 = x * x + y * y;
  const Eigen::Vector2d ray(camera.fx * x, camera.fy * y);
  if (camera.lens == LensModel::fisheye) {
    const double k[4] = {camera.k1, camera.k2, camera.k3, camera.k4};
    const FisheyeScale<double> s = fisheye_scale(k, r2);
    double power = s.ratio;
    for (int column = 4; column < 8; ++column) slope.col(column) = (power *= s.angle_squared) * ray;
    slope.col(8).setZero();
    return slope;
  }
  const double r4 = r2 * r2;
  slope.col(4) = r2 * ray;
  slope.col(5) = r4 * ray;
  slope.col(6) = r4 * r2 * ray;
  slope.col(7) << camera.fx * 2 * x * y, camera.fy * (r2 + 2 * y * y);
  slope.col(8) << camera.fx * (r2 + 2 * x * x), camera.fy * 2 * x * y;
  return slope;
}

std::optional<Eigen::Vector2d> unproject(const InteriorOrientation& camera, const Eigen::Vector2d& pixel) {
  const Eigen::Vector2d target((pixel.x() - camera.cx) / camera.fx, (pixel.y() - camera.cy) / camera.fy);
  if (camera.lens == LensModel::fisheye) {
    const double drawn = target.norm();
    if (drawn < 1e-12) return target;
    const auto angle = fisheye_angle(camera, drawn);
    if (!angle) return std::nullopt;
    return Eigen::Vector2d(std::tan(*angle) / drawn * target);
  }
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

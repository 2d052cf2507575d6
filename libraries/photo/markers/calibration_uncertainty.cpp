// What the covariance of a calibration means over the image, and how far two calibrations differ there.
#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <cmath>
#include <optional>

#include "photo/markers/calibration.hpp"

namespace plumbline::markers {
namespace {

/// Directions of the grid's pixels, with the derivative of the pixel by a rotation of the direction.
struct Ray {
  bool valid = false;
  Eigen::Vector3d direction;
  Eigen::Matrix<double, 2, 3> by_rotation;
};

std::vector<Ray> rays_of(const BrownCamera& camera, int columns, int rows) {
  std::vector<Ray> rays;
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column) {
      Ray ray;
      const auto q = unproject(camera, grid_pixel(camera, columns, rows, column, row));
      if (q) {
        ray.direction = q->homogeneous().normalized();
        const auto slope = project_with_slope(camera, ray.direction);
        ray.valid = slope.has_value();
        if (slope) ray.by_rotation = slope->by_point * -skew(ray.direction);
      }
      rays.push_back(ray);
    }
  return rays;
}

}  // namespace

Eigen::Vector2d grid_pixel(const BrownCamera& camera, int columns, int rows, int column, int row) {
  return {(camera.width - 1.0) * column / (columns - 1), (camera.height - 1.0) * row / (rows - 1)};
}

std::vector<double> projection_uncertainty(const BrownCamera& camera, const Eigen::MatrixXd& covariance, int columns,
                                           int rows) {
  const std::vector<Ray> rays = rays_of(camera, columns, rows);
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Matrix<double, 3, BrownCamera::parameter_count> right =
      Eigen::Matrix<double, 3, BrownCamera::parameter_count>::Zero();
  std::vector<Eigen::Matrix<double, 2, BrownCamera::parameter_count>> slopes(rays.size());
  for (size_t i = 0; i < rays.size(); ++i) {
    if (!rays[i].valid) continue;
    const Eigen::Vector2d ray = rays[i].direction.hnormalized();
    slopes[i] = pixel_by_parameters(camera, ray.x(), ray.y());
    normal += rays[i].by_rotation.transpose() * rays[i].by_rotation;
    right += rays[i].by_rotation.transpose() * slopes[i];
  }
  const Eigen::Matrix<double, 3, BrownCamera::parameter_count> rotation = normal.ldlt().solve(right);
  std::vector<double> result;
  for (size_t i = 0; i < rays.size(); ++i) {
    if (!rays[i].valid) {
      result.push_back(std::nan(""));
      continue;
    }
    const Eigen::Matrix<double, 2, BrownCamera::parameter_count> total = slopes[i] - rays[i].by_rotation * rotation;
    const Eigen::Matrix2d c = total * covariance * total.transpose();
    const double mean = 0.5 * c.trace();
    result.push_back(std::sqrt(std::max(0.0, mean + std::hypot(0.5 * (c(0, 0) - c(1, 1)), c(0, 1)))));
  }
  return result;
}

std::vector<double> projection_difference(const BrownCamera& a, const BrownCamera& b, int columns, int rows) {
  const std::vector<Ray> rays = rays_of(a, columns, rows);
  Eigen::Quaterniond turn = Eigen::Quaterniond::Identity();
  const auto difference = [&](const Ray& ray, int column, int row) -> std::optional<Eigen::Vector2d> {
    const auto pixel = project(b, turn * ray.direction);
    if (!ray.valid || !pixel) return std::nullopt;
    return *pixel - grid_pixel(a, columns, rows, column, row);
  };
  for (int iteration = 0; iteration < 5; ++iteration) {
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (int row = 0; row < rows; ++row)
      for (int column = 0; column < columns; ++column) {
        const Ray& ray = rays[row * columns + column];
        const auto d = difference(ray, column, row);
        if (!d) continue;
        normal += ray.by_rotation.transpose() * ray.by_rotation;
        right += ray.by_rotation.transpose() * *d;
      }
    turn = quaternion_from_rotation_vector(-normal.ldlt().solve(right)) * turn;
  }
  std::vector<double> result;
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column) {
      const auto d = difference(rays[row * columns + column], column, row);
      result.push_back(d ? d->norm() : std::nan(""));
    }
  return result;
}

}  // namespace plumbline::markers

// The cost functions of a calibration: what a point of the board is off by in a photograph, and the prior of its bend.
#pragma once

#include <ceres/rotation.h>

#include <Eigen/Core>

#include "photo/markers/calibration.hpp"

namespace plumbline::markers {

/// Pixel of normalised coordinates through a fisheye: fx, fy, cx, cy, k1 ... k4.
template <typename T>
void project_fisheye(const T* p, const T& x, const T& y, T* pixel) {
  const T r2 = x * x + y * y;
  T scale(1);
  if (r2 > T(1e-16)) {
    const T r = sqrt(r2), angle = atan(r), a2 = angle * angle;
    scale = angle * (T(1) + a2 * (p[4] + a2 * (p[5] + a2 * (p[6] + a2 * p[7])))) / r;
  }
  pixel[0] = p[0] * scale * x + p[2], pixel[1] = p[1] * scale * y + p[3];
}

/// One point. Parameters: pose (translation, rotation vector on top of the approximate one), interior orientation,
/// bend.
struct PointCost {
  Eigen::Vector3d board;
  Eigen::Vector2d pixel, unit;  // `unit`: the point from −1 to 1 over the board
  double sigma;
  LensModel lens;
  const Eigen::Matrix3d* camera_matrix;

  template <typename T>
  bool operator()(const T* pose, const T* interior, const T* bend, T* residual) const {
    using Vector = Eigen::Matrix<T, 3, 1>;
    const T z = T(board.z()) + bend[0] * T(1 - unit.x() * unit.x()) + bend[1] * T(1 - unit.y() * unit.y());
    const Vector start = camera_matrix->cast<T>() * Vector(T(board.x()), T(board.y()), z);
    Vector turned;
    ceres::AngleAxisRotatePoint(pose + 3, start.data(), turned.data());
    const T depth = turned[2] + pose[2];
    if (!(depth > T(1e-9))) return false;
    T computed[2];
    const T x = (turned[0] + pose[0]) / depth, y = (turned[1] + pose[1]) / depth;
    if (lens == LensModel::brown)
      project_normalised(interior, x, y, computed);
    else
      project_fisheye(interior, x, y, computed);
    residual[0] = (computed[0] - T(pixel.x())) / T(sigma);
    residual[1] = (computed[1] - T(pixel.y())) / T(sigma);
    return true;
  }
};

struct ScaledCost {
  double sigma;
  template <typename T>
  bool operator()(const T* bend, T* residual) const {
    residual[0] = bend[0] / T(sigma), residual[1] = bend[1] / T(sigma);
    return true;
  }
};

}  // namespace plumbline::markers

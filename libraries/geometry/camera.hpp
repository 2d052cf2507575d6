// The pinhole camera with Brown's distortion, as OpenCV and COLMAP parametrise it.
//
// Camera frame: x right, y down, z forward [m]. Pixel coordinates: the centre of the top-left pixel is (0, 0);
// libapriltag and COLMAP place it at (0.5, 0.5), so whoever reads from or writes to them shifts by half a pixel.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

namespace plumbline {

/// Interior orientation. Principal distances and principal point in px; the distortion coefficients act on normalised
/// image coordinates and have no unit. Source of the model: Brown (1971), Close-range camera calibration; coefficient
/// order and signs as in OpenCV.
struct BrownCamera {
  int width = 0;   ///< [px]
  int height = 0;  ///< [px]
  double fx = 0, fy = 0;
  double cx = 0, cy = 0;
  double k1 = 0, k2 = 0, k3 = 0;
  double p1 = 0, p2 = 0;

  /// Order of the parameters wherever they stand in a vector: fx, fy, cx, cy, k1, k2, k3, p1, p2.
  static constexpr int parameter_count = 9;
  static constexpr std::array<const char*, parameter_count> parameter_names = {"fx", "fy", "cx", "cy", "k1",
                                                                               "k2", "k3", "p1", "p2"};
  std::array<double, parameter_count> parameters() const { return {fx, fy, cx, cy, k1, k2, k3, p1, p2}; }
  void set_parameters(const std::array<double, parameter_count>& v) {
    fx = v[0], fy = v[1], cx = v[2], cy = v[3], k1 = v[4], k2 = v[5], k3 = v[6], p1 = v[7], p2 = v[8];
  }
};

/// Projects normalised image coordinates (x/z, y/z) to pixels. Template, so that automatic differentiation can pass
/// through: `parameters` points to 9 values in the order of BrownCamera::parameter_names, `pixel` to 2.
template <typename T>
void project_normalised(const T* parameters, const T& x, const T& y, T* pixel) {
  const T r2 = x * x + y * y;
  const T radial = T(1) + r2 * (parameters[4] + r2 * (parameters[5] + r2 * parameters[6]));
  const T xd = x * radial + T(2) * parameters[7] * x * y + parameters[8] * (r2 + T(2) * x * x);
  const T yd = y * radial + parameters[7] * (r2 + T(2) * y * y) + T(2) * parameters[8] * x * y;
  pixel[0] = parameters[0] * xd + parameters[2];
  pixel[1] = parameters[1] * yd + parameters[3];
}

/// Pixel of a point given in the camera frame [m]; nothing for a point at or behind the projection centre.
std::optional<Eigen::Vector2d> project(const BrownCamera& camera, const Eigen::Vector3d& point_in_camera);

/// The same with the derivatives of the pixel by the point, [px/m].
struct ProjectionWithSlope {
  Eigen::Vector2d pixel;
  Eigen::Matrix<double, 2, 3> by_point;
};
std::optional<ProjectionWithSlope> project_with_slope(const BrownCamera& camera,
                                                      const Eigen::Vector3d& point_in_camera);

/// Normalised image coordinates (x/z, y/z) of a pixel, free of distortion (Newton's method, to 1e-13); nothing where
/// the distortion polynomial has no inverse, which is outside any image the camera was calibrated on.
std::optional<Eigen::Vector2d> unproject(const BrownCamera& camera, const Eigen::Vector2d& pixel);

}  // namespace plumbline

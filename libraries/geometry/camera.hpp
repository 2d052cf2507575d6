// The interior orientation of a camera: a pinhole with Brown's distortion, or a fisheye, each as OpenCV and COLMAP
// parametrise it.
//
// Camera frame: x right, y down, z forward [m]. Pixel coordinates: the centre of the top-left pixel is (0, 0);
// libapriltag and COLMAP place it at (0.5, 0.5), so whoever reads from or writes to them shifts by half a pixel.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <span>
#include <string_view>

namespace plumbline {

/// How a lens bends rays.
enum class LensModel {
  /// A polynomial of the tangent with decentring. Source: Brown (1971), Close-range camera calibration; coefficient
  /// order and signs as in OpenCV. COLMAP: OPENCV, with k3 FULL_OPENCV.
  brown,
  /// A polynomial of the angle θ off the axis: a direction is drawn θ (1 + k1 θ² + k2 θ⁴ + k3 θ⁶ + k4 θ⁸) from the
  /// principal point. Source: Kannala & Brandt (2006), PAMI 28(8); OpenCV's fisheye model, Kalibr's "equidistant",
  /// COLMAP's OPENCV_FISHEYE. What lies 90° and more off the axis has no image here.
  fisheye,
};

/// "brown", "fisheye".
std::string_view name_of(LensModel lens);
std::optional<LensModel> lens_called(std::string_view name);

/// Principal distances and principal point in px; the distortion coefficients have no unit.
struct InteriorOrientation {
  int width = 0;   ///< [px]
  int height = 0;  ///< [px]
  double fx = 0, fy = 0;
  double cx = 0, cy = 0;
  double k1 = 0, k2 = 0, k3 = 0;
  double p1 = 0, p2 = 0;  ///< Brown's only
  LensModel lens = LensModel::brown;
  double k4 = 0;  ///< the fisheye's only

  /// Places of the parameters wherever they stand in a vector, in the order of names(): nine, of which a fisheye leaves
  /// the last unused and zero.
  static constexpr int parameter_count = 9;
  std::array<double, parameter_count> parameters() const {
    if (lens == LensModel::fisheye) return {fx, fy, cx, cy, k1, k2, k3, k4, 0};
    return {fx, fy, cx, cy, k1, k2, k3, p1, p2};
  }
  void set_parameters(const std::array<double, parameter_count>& v) {
    fx = v[0], fy = v[1], cx = v[2], cy = v[3], k1 = v[4], k2 = v[5], k3 = v[6];
    if (lens == LensModel::fisheye)
      k4 = v[7];
    else
      p1 = v[7], p2 = v[8];
  }
  /// fx, fy, cx, cy, k1, k2, k3, then p1 and p2 of Brown's model, k4 of the fisheye's.
  static std::span<const char* const> names_of(LensModel lens);
  std::span<const char* const> names() const { return names_of(lens); }
};
/// Its name from when there was one lens.
using BrownCamera = InteriorOrientation;

/// Pixel of a point given in the camera frame [m]; nothing for a point at or behind the projection centre.
std::optional<Eigen::Vector2d> project(const InteriorOrientation& camera, const Eigen::Vector3d& point_in_camera);

/// The same with the derivatives of the pixel by the point, [px/m].
struct ProjectionWithSlope {
  Eigen::Vector2d pixel;
  Eigen::Matrix<double, 2, 3> by_point;
};
std::optional<ProjectionWithSlope> project_with_slope(const InteriorOrientation& camera,
                                                      const Eigen::Vector3d& point_in_camera);

/// Derivatives by the parameters, in their places, of the pixel of what lies at the normalised image coordinates (x,
/// y).
Eigen::Matrix<double, 2, InteriorOrientation::parameter_count> pixel_by_parameters(const InteriorOrientation& camera,
                                                                                   double x, double y);

/// Normalised image coordinates (x/z, y/z) of a pixel, free of distortion (Newton's method, to 1e-13); nothing where
/// the distortion polynomial has no inverse, which is outside any image the camera was calibrated on, and where the
/// direction is 90° or more off the axis.
std::optional<Eigen::Vector2d> unproject(const InteriorOrientation& camera, const Eigen::Vector2d& pixel);

}  // namespace plumbline

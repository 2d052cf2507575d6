// Bundle adjustment of a general point block as close-range industrial photogrammetry does it: circular targets
// measured in many images by one or a few cameras, scale bars, no control. Free network with inner constraints and
// self-calibration.
//
// Units: object space in metres, sensor plane in millimetres (that is how the field writes Ck, A1 …), angles in
// radians. Frames: v = Rᵀ(X − C) with R = Rx(ω) Ry(φ) Rz(κ); sensor x right, y up, and the scene at negative v_z, hence
// Ck < 0.
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "block/block_model.hpp"

namespace plumbline::adjust {

/// Interior orientation. With r² = x² + y² of the undistorted sensor coordinates (x, y) = Ck·(v_x, v_y)/v_z:
///   dr = A1 (r² − R0²) + A2 (r⁴ − R0⁴) + A3 (r⁶ − R0⁶)
///   x' = xh + x + x·dr + B1 (r² + 2x²) + 2 B2 x y + C1 x + C2 y
///   y' = yh + y + y·dr + B2 (r² + 2y²) + 2 B1 x y
/// Source: Brown (1971) in the balanced form of Luhmann et al. (2019), Close-Range Photogrammetry and 3D Imaging, 3.3.
struct SensorCamera {
  static constexpr int parameter_count = 10;
  static constexpr std::array<const char*, parameter_count> names = {"Ck", "xh", "yh", "A1", "A2",
                                                                     "A3", "B1", "B2", "C1", "C2"};
  int id = 0;
  std::array<double, parameter_count> values{};  ///< in the order of `names`; mm, and powers of 1/mm
  double balance_radius = 0;                     ///< R0 [mm]
  double sensor_width = 0, sensor_height = 0;    ///< [mm]
  int width = 0, height = 0;                     ///< [px]
};

struct BlockImage {
  int id = 0;
  int camera = 0;                                    ///< index into PointBlock::cameras
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< projection centre in the block frame [m]
  Eigen::Vector3d angles = Eigen::Vector3d::Zero();  ///< ω, φ, κ [rad]
};

struct BlockPoint {
  std::string name;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< [m]
};

struct BlockMeasurement {
  int image = 0;                                       ///< index into PointBlock::images
  int point = 0;                                       ///< index into PointBlock::points
  Eigen::Vector2d position = Eigen::Vector2d::Zero();  ///< [mm] on the sensor
  double sigma = 0;                                    ///< a priori [mm]; 0: PointBlockOptions::image_sigma
};

struct ScaleBar {
  std::string name;
  int from = 0, to = 0;  ///< indices into PointBlock::points
  double length = 0;     ///< [m]
  double sigma = 0;      ///< [m]
};

struct PointBlock {
  std::vector<SensorCamera> cameras;
  std::vector<BlockImage> images;
  std::vector<BlockPoint> points;
  std::vector<BlockMeasurement> measurements;
  std::vector<ScaleBar> scale_bars;
};

struct PointBlockOptions {
  double image_sigma = 0.0005;  ///< a priori standard deviation of a sensor coordinate of weight 1 [mm]
  std::vector<std::string> free_parameters = {"Ck", "xh", "yh", "A1", "A2", "B1", "B2"};  ///< of every camera
  int max_iterations = 100;
};

struct PointBlockResult {
  PointBlock block;                    ///< adjusted
  double sigma0 = 0;                   ///< a posteriori, as sensor coordinate [mm]
  double weighted_sum_of_squares = 0;  ///< Σ p v², p = σ_a_priori²/σ², so that sigma0² = it / degrees_of_freedom [mm²]
  int observations = 0;
  int unknowns = 0;
  int constraints = 0;
  int degrees_of_freedom = 0;
  int iterations = 0;
  std::vector<adjustment::VarianceComponent> groups;
  std::vector<int> free_parameters;  ///< indices into SensorCamera::names
  /// All covariances are scaled with sigma0 and belong to the inner constraints.
  Eigen::MatrixXd point_covariance;                  ///< 3n × 3n [m²]
  std::vector<Eigen::MatrixXd> interior_covariance;  ///< one a camera, in the order of `free_parameters`
  std::vector<Matrix6> pose_covariance;              ///< centre [m], then rotation about the camera's own axes [rad]
  std::vector<Eigen::Matrix3d> angle_covariance;     ///< ω, φ, κ [rad²]
  /// 6 × free parameters each: correlation of the pose (centre, rotations about the camera axes) with its camera's
  /// interior orientation.
  std::vector<Eigen::MatrixXd> pose_interior_correlation;
  std::vector<std::array<adjustment::RowStatistics, 2>>
      measurement_reliability;                                   ///< [mm] on the sensor, like PointBlock::measurements
  std::vector<adjustment::RowStatistics> scale_bar_reliability;  ///< [m]
};

/// R = Rx(ω) Ry(φ) Rz(κ): block from camera. And its inverse, with φ in (−π/2, π/2].
Eigen::Matrix3d rotation_from_angles(const Eigen::Vector3d& angles);
Eigen::Vector3d angles_from_rotation(const Eigen::Matrix3d& rotation);

/// Least-squares adjustment, started from the values in `block`. The datum is that of the given point coordinates: no
/// translation and no rotation of the points against them (and no change of scale if there is no scale bar). Throws
/// std::runtime_error that names what is undetermined: fewer than two images, a point seen once, an image with fewer
/// than three points, a point behind its camera, any other rank defect; or that the iteration did not converge.
PointBlockResult adjust_point_block(const PointBlock& block, const PointBlockOptions& options);

}  // namespace plumbline::adjust

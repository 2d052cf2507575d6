// Bundle adjustment of a general point block as close-range photogrammetry does it: targets measured in many images by
// one or several cameras; scale bars, known points fixed or weighted, self-calibration. Without known points the
// network is free, with inner constraints. A front-end to the block model of block/bundle: readers of other programs'
// files fill it, and its results are what those programs report.
//
// Units: object space in metres, sensor plane in millimetres (that is how the field writes Ck, A1 …), angles in
// radians. Frames: v = Rᵀ(X − C) with R = Rx(ω) Ry(φ) Rz(κ); sensor x right, y up, and the scene at negative v_z.
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "photo/bundle/adjust.hpp"

namespace plumbline::block {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// Interior orientation, of one of the models that work in the sensor plane; see block/bundle/lens.hpp for both.
struct SensorCamera {
  static constexpr int parameter_count = bundle::max_interior;
  int id = 0;
  bundle::Lens lens = bundle::Lens::balanced;    ///< balanced (Ck, xh, …) or correcting (c, xp, …)
  std::array<double, parameter_count> values{};  ///< in the order of names(); mm, and powers of 1/mm
  double balance_radius = 0;                     ///< R0 of the balanced model [mm]
  double sensor_width = 0, sensor_height = 0;    ///< [mm]
  int width = 0, height = 0;                     ///< [px]
  std::vector<std::string> estimated;            ///< what "auto" estimates of it; empty: what its lens says
  const std::vector<std::string>& names() const { return bundle::value_names(lens); }
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

/// Points whose coordinates are known in the frame of the result.
struct BlockControl {
  std::vector<int> points;     ///< indices into PointBlock::points
  std::vector<bool> is_check;  ///< known, but compared with only
  Eigen::VectorXd position;    ///< 3m [m]
  Eigen::MatrixXd covariance;  ///< 3m × 3m [m²]; a point whose three variances are 0 is held at its coordinates
};

struct PointBlock {
  std::vector<SensorCamera> cameras;
  std::vector<BlockImage> images;
  std::vector<BlockPoint> points;
  std::vector<BlockMeasurement> measurements;
  std::vector<ScaleBar> scale_bars;
  BlockControl control;
};

struct PointBlockOptions {
  double image_sigma = 0.0005;  ///< a priori standard deviation of a sensor coordinate of weight 1 [mm]
  /// Image coordinates are weighted by what they show of themselves where anything else is observed (Helmert's
  /// component of their group): programs state their standard deviation to a factor of five at best, and what control
  /// and scale bars are worth beside them, and what is stated of all, hangs on it.
  bool estimate_image_variance = false;
  /// Interior parameters to estimate, of every camera whose model has them. "auto" stands for Ck, xh, yh, A1, A2, B1,
  /// B2 of a balanced camera, and for none of a correcting one, which comes calibrated; see SensorCamera::estimated.
  std::vector<std::string> free_parameters = {"auto"};
  /// Standard deviation of each image's own principal point about its camera's [mm]; 0: the images of a camera share
  /// one.
  double principal_point_sigma = 0;
  enum class FreeDatum {
    inner,       ///< inner constraints over all points
    first_image  ///< pose of the first image, and one coordinate of the image furthest from it
  } free_datum = FreeDatum::inner;
  int max_iterations = 100;
  int threads = 1;
  bundle::Side side = bundle::Side::automatic;
  bundle::Minimiser minimiser = bundle::minimise_schur;
  /// Conjugate gradients in place of a factor, for blocks that have no room for one. All covariances and redundancy
  /// numbers, w and MDB are NaN then, point_covariance is empty; see bundle::adjust_by_gradients() for what of rank is
  /// seen.
  bool by_gradients = false;
  std::function<void(std::size_t)> announce;  ///< see bundle::AdjustOptions
};

struct ControlResult {
  int point = 0;  ///< index into PointBlock::points
  bool check = false, fixed = false;
  bool aside = false;                               ///< contradicts, and took no part: adjust_without_wrong_control()
  Eigen::Vector3d given = Eigen::Vector3d::Zero();  ///< [m]
  Eigen::Vector3d given_sigma = Eigen::Vector3d::Zero();  ///< [m]
  Eigen::Vector3d residual = Eigen::Vector3d::Zero();     ///< adjusted minus given [m]
  Eigen::Vector3d w = Eigen::Vector3d::Zero();  ///< normalised residual; of what took no part with both covariances
  Eigen::Vector3d redundancy_number = Eigen::Vector3d::Zero();
  int rays = 0;
};

struct PointBlockResult {
  PointBlock block;                  ///< adjusted
  double sigma0 = 0;                 ///< a posteriori, as sensor coordinate [mm]
  double image_variance_factor = 1;  ///< that image coordinates were weighted by, against what they came with
  double weighted_sum_of_squares = 0;  ///< Σ p v², p = σ_a_priori²/σ², so that sigma0² = it / degrees_of_freedom [mm²]
  int observations = 0;
  int unknowns = 0;
  int constraints = 0;
  int degrees_of_freedom = 0;
  int iterations = 0;
  std::vector<least_squares::VarianceComponent> groups;
  std::vector<std::vector<int>> free_parameters;  ///< of each camera: indices into its names
  /// All covariances are scaled with sigma0 and belong to the datum.
  std::vector<Eigen::Matrix3d> point_covariances;    ///< one a point [m²], zero for one that is held
  Eigen::MatrixXd point_covariance;                  ///< 3n × 3n [m²]; empty above max_joint_points
  std::vector<Eigen::MatrixXd> interior_covariance;  ///< one a camera, in the order of its `free_parameters`
  std::vector<Eigen::Vector2d> principal_points;     ///< one an image if they have their own: beyond the camera's [mm]
  std::vector<Eigen::Matrix2d> principal_point_covariance;  ///< of them [mm²]
  std::vector<Matrix6> pose_covariance;         ///< centre [m], then rotation about the camera's own axes [rad]
  std::vector<Matrix6> orientation_covariance;  ///< centre [m], then ω, φ, κ [rad]
  /// 6 × free parameters each: correlation of the pose (centre, rotations about the camera axes) with its camera's
  /// interior orientation.
  std::vector<Eigen::MatrixXd> pose_interior_correlation;
  std::vector<std::array<least_squares::RowStatistics, 2>>
      measurement_reliability;  ///< [mm] on the sensor, like PointBlock::measurements
  std::vector<least_squares::RowStatistics> scale_bar_reliability;  ///< [m]
  std::vector<ControlResult> control;                               ///< in the order of PointBlock::control
  /// 3m × 3m of what the check points of `control` are off, block and survey together [m²], in their order; empty
  /// where there are none, more than max_joint_points, no covariances, or a check point without standard deviations.
  Eigen::MatrixXd check_covariance;
  std::vector<int> rays;  ///< one a point: images that measured it
};

/// Above this number of points their joint covariance is left out: it grows with the square.
constexpr size_t max_joint_points = 600;

/// R = Rx(ω) Ry(φ) Rz(κ): block from camera. And its inverse, with φ in (−π/2, π/2].
Eigen::Matrix3d rotation_from_angles(const Eigen::Vector3d& angles);
Eigen::Vector3d angles_from_rotation(const Eigen::Matrix3d& rotation);

/// Least-squares adjustment, started from the values in `block`; approximate values in another frame than the control
/// are carried over to it first, from three control points on. Without control, the datum is that of the given values
/// (PointBlockOptions::free_datum). Throws std::runtime_error that names what is undetermined: fewer than two images, a
/// point seen once, an image with fewer than three points, a point behind its camera, control that is not enough, any
/// other rank defect; or why the iteration did not converge.
PointBlockResult adjust_point_block(const PointBlock& block, const PointBlockOptions& options);

}  // namespace plumbline::block

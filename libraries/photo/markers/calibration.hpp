// Calibration of one camera on photographs of a board: interior orientation with its covariance, a board that may be
// bent, and what that uncertainty means over the image.
//
// Units: m, rad, px. The camera is Brown's or a fisheye, as OpenCV has them (geometry/camera.hpp).
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "geometry/camera.hpp"
#include "photo/markers/camera_changes.hpp"
#include "plumbline/rigid_transform.hpp"

namespace plumbline::markers {

struct CalibrationPoint {
  Eigen::Vector3d board;  ///< [m]
  Eigen::Vector2d pixel;
  double sigma = 0.1;  ///< [px]
  /// Where it lies if the edges of all tags are drawn inwards by a standard deviation of what the detector states of
  /// that, less where it is [px]. Zero of points where black and white fields meet, which no such thing moves.
  Eigen::Vector2d by_inset = Eigen::Vector2d::Zero();
};

struct CalibrationView {
  std::string path;
  std::vector<CalibrationPoint> points;
};

struct CalibrationOptions {
  LensModel lens = LensModel::brown;
  /// Of these, those that the lens has.
  std::vector<std::string> free = {"fx", "fy", "cx", "cy", "k1", "k2", "k3", "k4", "p1", "p2"};
  /// The board may be bent: z = a (1 − x²) + b (1 − y²), x and y from −1 to 1 over the board; a and b get this prior
  /// [m], 0 holds it flat.
  double bend_sigma = 0;
  double reject_above = 5;  ///< points whose residual is this many times the median are left out; 0 keeps all
  int max_iterations = 200;
  std::optional<InteriorOrientation> known = {};  ///< the camera is held at this, and `lens` and `free` do not count
};

struct CalibratedView {
  int view = 0;  ///< index into the given views
  RigidTransform cam_from_board;
  std::vector<int> points;                 ///< indices of those that took part
  std::vector<Eigen::Vector2d> residuals;  ///< measured minus computed, like `points` [px]
  double rms = 0;                          ///< √(Σ(dx² + dy²)/n), as OpenCV gives it [px]
  double tilt = 0;                         ///< of the board's normal against the line of sight [rad]
};

struct Calibration {
  InteriorOrientation camera;
  /// 9 × 9, zero for held parameters: the larger of what the residuals and what the scatter of the photographs say, and
  /// by_inset.
  Eigen::MatrixXd covariance;
  /// Nine: what CalibrationPoint::by_inset of all points together moves the parameters by (common_error.hpp).
  Eigen::VectorXd by_inset = Eigen::VectorXd::Zero(InteriorOrientation::parameter_count);
  /// Without what all photographs of this camera have in common.
  Eigen::MatrixXd own_covariance() const { return covariance - by_inset * by_inset.transpose(); }
  Eigen::MatrixXd formal_covariance;  ///< 9 × 9, of the corners' own errors alone, scaled with the residuals
  CameraTruth truth;                  ///< whether the photographs are of one camera, and how they scatter
  double bend_x = 0, bend_y = 0, bend_x_sigma = 0, bend_y_sigma = 0;  ///< [m]
  std::vector<CalibratedView> views;
  double rms = 0;    ///< √(Σ(dx² + dy²)/n) over all points, as OpenCV gives it [px]
  double sigma = 0;  ///< standard deviation of an image coordinate, from the residuals and their redundancy [px]
  int observations = 0, unknowns = 0, degrees_of_freedom = 0;
  std::vector<std::string> rejected;  ///< in words
  bool held_flat = false;     ///< the photographs did not tell a bend of the board from the lens, so it was held flat
  bool held_highest = false;  ///< nor the highest radial coefficient (k3, a fisheye's k4), which was held at zero
};

/// Throws std::runtime_error that says what is missing: fewer than three views or too few points, all views from one
/// direction, a rank defect by its unknowns, no convergence.
Calibration calibrate(const std::vector<CalibrationView>& views, int width, int height,
                      const CalibrationOptions& options);

/// Residuals that each lens leaves in photographs it was not fitted to: every second one calibrates, the others are
/// only oriented, and the other way round; no point is left out. √(Σ(dx² + dy²)/n) [px].
struct LensComparison {
  double brown = 0, fisheye = 0;
  double widest = 0;          ///< angle of a point off the axis, by the calibration [rad]
  bool held_out = false;      ///< false: of the photographs they were fitted to, which are too few to be divided
  bool only_fisheye = false;  ///< Brown's model fits nothing, the fisheye's does
  /// The fisheye's model, which has a parameter fewer, leaves less than 0.85 of the residuals.
  bool is_fisheye() const { return fisheye > 0 && fisheye < 0.85 * brown; }
};

/// Compares the lenses where points lie more than 35° off the axis; elsewhere both models are nearly the same, and
/// nothing is compared. `all`: a calibration with either.
LensComparison compare_lenses(const std::vector<CalibrationView>& views, const CalibrationOptions& options,
                              const Calibration& all);

/// The calibration with the lens that the photographs show: Brown's, unless compare_lenses() finds a fisheye, or only
/// the fisheye's model fits at all. Throws as calibrate().
struct CalibrationOfLens {
  Calibration calibration;
  LensComparison lenses;
};
CalibrationOfLens calibrate_lens_and_camera(const std::vector<CalibrationView>& views, int width, int height,
                                            CalibrationOptions options);

/// Standard deviation of a projected pixel over the image: what the covariance leaves after the rotation that fits best
/// is taken out, because an orientation takes that up. Largest over all directions, in a grid of columns × rows pixels
/// that covers the image, row by row [px].
std::vector<double> projection_uncertainty(const InteriorOrientation& camera, const Eigen::MatrixXd& covariance,
                                           int columns, int rows);

/// Two calibrations against each other over the same grid, the best fitting rotation taken out: length of the
/// difference [px]; nan where a pixel cannot be unprojected.
std::vector<double> projection_difference(const InteriorOrientation& a, const InteriorOrientation& b, int columns,
                                          int rows);

/// Pixel of a cell of that grid.
Eigen::Vector2d grid_pixel(const InteriorOrientation& camera, int columns, int rows, int column, int row);

}  // namespace plumbline::markers

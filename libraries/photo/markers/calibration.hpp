// Calibration of one camera on photographs of a board: interior orientation with its covariance, a board that may be
// bent, and what that uncertainty means over the image.
//
// Units: m, rad, px. The camera is Brown's as OpenCV has it (geometry/camera.hpp).
#pragma once

#include <Eigen/Core>
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
};

struct CalibrationView {
  std::string path;
  std::vector<CalibrationPoint> points;
};

/// How a lens bends rays: Brown's polynomial of the tangent, or, for comparison only, the polynomial of the angle that
/// fisheyes follow (Kannala and Brandt 2006, as OpenCV's fisheye model): r = θ (1 + k1 θ² + k2 θ⁴ + k3 θ⁶ + k4 θ⁸).
enum class LensModel { brown, fisheye };

struct CalibrationOptions {
  std::vector<std::string> free = {"fx", "fy", "cx", "cy", "k1", "k2", "k3", "p1", "p2"};
  /// The board may be bent: z = a (1 − x²) + b (1 − y²), x and y from −1 to 1 over the board; a and b get this prior
  /// [m], 0 holds it flat.
  double bend_sigma = 0;
  double reject_above = 5;  ///< points whose residual is this many times the median are left out; 0 keeps all
  int max_iterations = 200;
  LensModel lens = LensModel::brown;  ///< calibrate() takes Brown's only
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
  BrownCamera camera;
  /// 9 × 9, zero for held parameters: the larger of what the residuals and what the scatter of the photographs say.
  Eigen::MatrixXd covariance;
  Eigen::MatrixXd formal_covariance;  ///< 9 × 9, scaled with the residuals
  CameraTruth truth;                  ///< whether the photographs are of one camera, and how they scatter
  double bend_x = 0, bend_y = 0, bend_x_sigma = 0, bend_y_sigma = 0;  ///< [m]
  std::vector<CalibratedView> views;
  double rms = 0;    ///< √(Σ(dx² + dy²)/n) over all points, as OpenCV gives it [px]
  double sigma = 0;  ///< standard deviation of an image coordinate, from the residuals and their redundancy [px]
  int observations = 0, unknowns = 0, degrees_of_freedom = 0;
  std::vector<std::string> rejected;  ///< in words
  bool held_flat = false;  ///< the photographs did not tell a bend of the board from the lens, so it was held flat
  bool held_k3 = false;    ///< nor the third radial coefficient, which was held at zero
};

/// Throws std::runtime_error that says what is missing: fewer than three views or too few points, all views from one
/// direction, a rank defect by its unknowns, no convergence.
Calibration calibrate(const std::vector<CalibrationView>& views, int width, int height,
                      const CalibrationOptions& options);

/// Residuals of the same points with both lenses, none left out: √(Σ(dx² + dy²)/n) [px].
struct LensComparison {
  double brown = 0, fisheye = 0;
  double widest = 0;  ///< angle of a point off the axis, by the calibration [rad]
  /// That of a fisheye, which has a parameter fewer, leaves less than 0.85 of the residuals.
  bool is_fisheye() const { return fisheye > 0 && fisheye < 0.85 * brown; }
};

/// Compares the lenses where points lie more than 35° off the axis; elsewhere both models are nearly the same, and
/// nothing is compared. `all`: the calibration with Brown's lens.
LensComparison compare_lenses(const std::vector<CalibrationView>& views, const CalibrationOptions& options,
                              const Calibration& all);

/// Standard deviation of a projected pixel over the image: what the covariance leaves after the rotation that fits best
/// is taken out, because an orientation takes that up. Largest over all directions, in a grid of columns × rows pixels
/// that covers the image, row by row [px].
std::vector<double> projection_uncertainty(const BrownCamera& camera, const Eigen::MatrixXd& covariance, int columns,
                                           int rows);

/// Two calibrations against each other over the same grid, the best fitting rotation taken out: length of the
/// difference [px]; nan where a pixel cannot be unprojected.
std::vector<double> projection_difference(const BrownCamera& a, const BrownCamera& b, int columns, int rows);

/// Pixel of a cell of that grid.
Eigen::Vector2d grid_pixel(const BrownCamera& camera, int columns, int rows, int column, int row);

}  // namespace plumbline::markers

// A COLMAP model with surveyed points measured in its photographs: one adjustment of tie points, control and cameras in
// the frame of the survey. Control takes part in it with its standard deviations, it is not only fitted to.
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "control/points/control_point.hpp"
#include "least_squares/problem/reliability.hpp"
#include "photo/block/check_points.hpp"
#include "photo/cameras/colmap_files.hpp"

namespace plumbline::markers {

using control::ControlPoint;
using control::ImagePoint;

struct ControlOptions {
  double control_sigma = 0.005;  ///< of a surveyed coordinate whose file says none [m]
  double measured_sigma = 0.5;   ///< of a measured control point whose file says none [px]
  double tie_sigma = 1.0;        ///< of a tie point's image coordinate; scaled by its variance component [px]
  bool self_calibration = true;
  int max_tie_points = 600;    ///< those with the longest tracks; the others follow the cameras
  bool robust_control = true;  ///< control that contradicts the rest is set aside, at most a third of it
  double reject_above = 5;     ///< tie observations whose residual is this many times the median are left out
  int max_iterations = 100;
};

struct AdjustedControlPoint {
  std::string name;
  bool check = false, used = false;
  bool aside = false;  ///< control that contradicts the rest and took no part
  Eigen::Vector3d surveyed, surveyed_sigma, position;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  Eigen::Vector3d w = Eigen::Vector3d::Zero();  ///< normalised residuals; of what took no part, of the difference
  double nees = std::numeric_limits<double>::quiet_NaN();  ///< of the difference of what took no part; 3 of freedom
  bool contradicts = false;
  int rays = 0;
  double largest_angle = 0;  ///< [rad]
  double rms = 0;            ///< of its image coordinates [px]
  std::string reason;        ///< why it was not used
};

struct ControlObservation {
  std::string image, point;
  Eigen::Vector2d pixel, residual;  ///< measured minus computed [px]
  double w = 0;
  bool control = false;
};

struct ControlResult {
  cameras::ColmapModel model;  ///< in the frame of the survey
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  std::vector<AdjustedControlPoint> points;
  std::map<std::uint32_t, Eigen::MatrixXd> camera_covariance;            ///< 9 × 9
  std::map<std::uint32_t, Eigen::Matrix<double, 6, 6>> pose_covariance;  ///< centre [m], rotation [rad]
  std::map<std::uint32_t, double> image_rms;                             ///< [px]
  std::map<std::uint32_t, int> image_points;
  std::optional<block::CheckJudgement> checks;  ///< nothing without check points
  std::vector<ControlObservation> observations;
  std::vector<least_squares::VarianceComponent> groups;
  double scale = 1;            ///< metres a unit of the model
  double control_scatter = 1;  ///< how many times their stated standard deviations those of all control were taken
  double sigma0 = 0, rms = 0, weighted_sum_of_squares = 0;
  int n_observations = 0, unknowns = 0, degrees_of_freedom = 0, tie_points = 0, rejected = 0;
  std::vector<std::string> warnings, left_out;
};

/// Throws std::runtime_error that says what is missing: names that match no image of the model, fewer than three
/// control points with two rays, control on a line. Check points are judged, and what does not hold is a warning.
ControlResult adjust_with_control(const cameras::ColmapModel& model, const std::vector<ControlPoint>& control,
                                  const std::vector<ImagePoint>& measured, const ControlOptions& options);
/// The same; where it throws, the warnings of `result` say what was noticed before.
void adjust_with_control(const cameras::ColmapModel& model, const std::vector<ControlPoint>& control,
                         const std::vector<ImagePoint>& measured, const ControlOptions& options, ControlResult& result);

/// "control", "check", or what became of control that contradicts.
std::string role_of(const AdjustedControlPoint& point);

/// points.csv: every surveyed point, adjusted minus surveyed, and its tests. What is not known is an empty cell.
std::string control_table(const ControlResult& result);

}  // namespace plumbline::markers

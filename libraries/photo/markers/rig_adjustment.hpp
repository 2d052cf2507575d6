// Cameras that are fixed to each other and a board, in one adjustment: the rig's relative orientations are the same at
// every exposure, the board has a pose at each, every camera an interior orientation. Whether the rig moves before the
// board or the board before the rig makes no difference. Photogrammetric Computer Vision (Förstner & Wrobel 2016),
// 15.4.1.4, has the model.
//
// Units: m, rad, px.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "photo/markers/calibration.hpp"

namespace plumbline::markers {

/// A camera of the rig with its calibration of its own, the start of the common one.
struct RigCamera {
  std::string id;
  const std::vector<CalibrationView>* views = nullptr;
  const Calibration* calibration = nullptr;
};

struct AdjustedRigCamera {
  int camera = 0;  ///< index into the given cameras
  RigidTransform cam_from_reference;
  /// Of a rotation vector in the camera's frame [rad], then of the translation [m]; zero for the reference.
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  /// Of that, a column for each camera of the rig: what the inset of its photographs (CalibrationPoint::by_inset)
  /// moves.
  Eigen::Matrix<double, 6, Eigen::Dynamic> by_inset;
  BrownCamera interior;
  Eigen::MatrixXd interior_covariance;  ///< 9 × 9, scaled with the residuals, the insets of all cameras with it
  double rms = 0, separate_rms = 0;     ///< √(Σ(dx² + dy²)/n) here and in the calibration of its own [px]
  int shared = 0;                       ///< exposures that another camera of the rig took, too
  /// Mean square of the difference between two halves of the exposures over its covariance, 1 if the covariance is
  /// true; nan where a half is too few.
  double halves = 0;
};

struct AdjustedRig {
  int reference = 0;                       ///< index into the given cameras
  std::vector<AdjustedRigCamera> cameras;  ///< with the reference
  double rms = 0, sigma = 0;               ///< as in Calibration [px]
  int exposures = 0, observations = 0, unknowns = 0, degrees_of_freedom = 0;
  std::string held;                   ///< in words, what was not estimated because the photographs do not determine it
  std::vector<std::string> left_out;  ///< photographs in which the board is not where the rig has it
  std::string refused;  ///< in words, why these photographs are none of a rig; the cameras' poses then mean nothing
};

/// One rig for every set of cameras that exposures connect. `moments[c][v]` names the exposure of view v of camera c.
/// Cameras without three exposures in common with another one belong to no rig. What the photographs do not determine
/// of the interior orientations is held at the values of the cameras' own calibrations.
std::vector<AdjustedRig> adjust_rigs(const std::vector<RigCamera>& cameras,
                                     const std::vector<std::vector<std::string>>& moments,
                                     const CalibrationOptions& options);

}  // namespace plumbline::markers

// Files with the interior orientation of a camera, as programs for calibration write them.
#pragma once

#include <Eigen/Core>
#include <string>

#include "geometry/camera.hpp"

namespace plumbline::markers {

struct CameraFile {
  std::string id;
  BrownCamera camera;          ///< width and height 0 if the file does not say them
  Eigen::MatrixXd covariance;  ///< 9 × 9; empty if the file has none
  std::string format;          ///< "Plumbline", "OpenCV", "Kalibr" ..., for messages
};

/// Reads a camera from YAML, JSON or XML: our own, OpenCV's FileStorage (camera_matrix, distortion_coefficients under
/// their usual names), ROS camera_info, Kalibr's camchain (its first camera, or the one called `which`), PhotonVision.
/// Throws std::runtime_error that names `file`, what was found and what was expected; also for models that are not
/// Brown's (fisheye, rational with more than five coefficients that are not zero).
CameraFile parse_camera_file(const std::string& text, const std::string& file, const std::string& which = "");

/// Our own format, as campaign folders take it; docs/campaign_folder.md.
std::string camera_yaml(const CameraFile& camera);

}  // namespace plumbline::markers

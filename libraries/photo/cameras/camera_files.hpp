// Files with the interior orientation of a camera, as programs for calibration write them.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "geometry/camera.hpp"

namespace plumbline::cameras {

struct CameraFile {
  std::string id;
  InteriorOrientation camera;             ///< width and height 0 if the file does not say them
  Eigen::MatrixXd covariance;             ///< 9 × 9; empty if the file has none
  std::string format;                     ///< "Plumbline", "OpenCV", "Kalibr" ..., for messages
  std::vector<std::string> remarks = {};  ///< written above the parameters, for people
};

/// Reads a camera from YAML, JSON or XML: our own, OpenCV's FileStorage (camera_matrix, distortion_coefficients under
/// their usual names), ROS camera_info, Kalibr's camchain (of one camera, or the one called `which`), PhotonVision.
/// Fisheyes are Kannala and Brandt's (OpenCV's fisheye, ROS' and Kalibr's equidistant). Throws std::runtime_error
/// that names `file`, what was found and what was expected; also for models that are neither this nor Brown's (double
/// sphere, rational with more than five coefficients that are not zero).
CameraFile parse_camera_file(const std::string& text, const std::string& file, const std::string& which = "");

/// All cameras of a file of ours or of Kalibr's that holds several, each under its name; else, or with `which`, the one
/// camera that parse_camera_file reads.
std::vector<CameraFile> parse_camera_files(const std::string& text, const std::string& file,
                                           const std::string& which = "");

/// 9 × 9: what a calibration that does not state its uncertainty is usually good for, a thousandth of the principal
/// distance and distortion to match.
Eigen::MatrixXd usual_covariance(const InteriorOrientation& camera);

/// Our own format, as campaign folders take it, with standard deviations and correlations; docs/campaign_folder.md.
std::string camera_yaml(const CameraFile& camera);

}  // namespace plumbline::cameras

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "photo/cameras/camera_files.hpp"

namespace plumbline::cameras {

namespace {

/// Lines that a reader skips.
std::string in_comment(const std::vector<std::string>& remarks) {
  std::string text;
  for (const std::string& remark : remarks) {
    text += "# ";
    for (const char c : remark) text += static_cast<unsigned char>(c) < 32 ? ' ' : c;
    text += "\n";
  }
  return text;
}

}  // namespace

std::string camera_yaml(const CameraFile& file) {
  const auto number = [](double value) { return fmt::format("{:.17g}", value); };
  std::string id;
  for (const char c : file.id) id += c == '"' || c == '\\' || static_cast<unsigned char>(c) < 32 ? '_' : c;
  std::string text = in_comment(file.remarks) + "plumbline_camera: 1\nid: \"" + id +
                     "\"\nwidth: " + std::to_string(file.camera.width) +
                     "\nheight: " + std::to_string(file.camera.height) +
                     "\npixel_origin: centre     # the centre of the top-left pixel is (0, 0), as OpenCV has it\n";
  text += file.camera.lens == LensModel::fisheye
              ? "lens: fisheye            # Kannala and Brandt, as OpenCV's fisheye, Kalibr's equidistant\n"
                "parameters:              # px; k1 to k4 of the angle off the axis\n"
              : "parameters:              # px; Brown's distortion, order and signs of OpenCV\n";
  const auto values = file.camera.parameters();
  const auto names = file.camera.names();
  const auto count = static_cast<Eigen::Index>(names.size());
  for (size_t i = 0; i < names.size(); ++i) text += std::string("  ") + names[i] + ": " + number(values[i]) + "\n";
  if (file.covariance.size() == 0) return text;
  text += "sigmas:                  # standard deviations; 0: held\n";
  for (Eigen::Index i = 0; i < count; ++i)
    text += std::string("  ") + names[i] + ": " + number(std::sqrt(std::max(0.0, file.covariance(i, i)))) + "\n";
  if (file.covariance.isDiagonal(0)) return text;
  text += "correlations:            # of each with those before it, in the order above\n";
  for (Eigen::Index i = 1; i < count; ++i) {
    text += std::string("  ") + names[i] + ": [";
    for (Eigen::Index j = 0; j < i; ++j) {
      const double scale = std::sqrt(file.covariance(i, i) * file.covariance(j, j));
      text += (j ? ", " : "") + (scale > 0 ? number(file.covariance(i, j) / scale) : "0");
    }
    text += "]\n";
  }
  return text;
}

}  // namespace plumbline::cameras

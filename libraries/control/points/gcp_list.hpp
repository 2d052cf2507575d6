// OpenDroneMap's gcp_list.txt: a projection, then a line for every place where a point was measured.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

namespace plumbline::control {

/// A line of gcp_list.txt: x y z column row image [name].
struct GcpLine {
  Eigen::Vector3d position;  ///< [m]
  Eigen::Vector2d pixel;     ///< as it is written
  std::string image, name;   ///< points without a name are told apart by their coordinates
};

/// The lines after the projection, separated by blanks or, where names hold blanks, by tabs; nothing if the text is no
/// gcp_list. Throws std::runtime_error that names file and line, also for a projection that does not count in metres
/// or is written as WKT.
std::optional<std::vector<GcpLine>> gcp_lines(const std::string& text, const std::string& file);

}  // namespace plumbline::control

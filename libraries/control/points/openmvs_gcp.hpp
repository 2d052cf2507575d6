// Ground control of openMVS: one table with a row for every place where a point was measured.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace plumbline::control {

struct GcpRow {
  std::string point, image;
  Eigen::Vector2d pixel;     ///< as it is written
  Eigen::Vector3d position;  ///< [m]
  Eigen::Vector3d sigma;     ///< [m]; nan where the file says none
};

/// Whether the text is a table whose first row names gcp_label, image_file_name and x_map.
bool looks_like_openmvs_gcp(const std::string& text);

/// gcp_label, image_file_name, x, y, x_map, y_map, elev and perhaps x_map_acc, y_map_acc, elev_acc, by their names in
/// the first row. An accuracy of zero, or an empty one, says none. Throws std::runtime_error that names file and line:
/// for rows of one point that differ in its coordinates, for a point that is twice in one image.
std::vector<GcpRow> parse_openmvs_gcp(const std::string& text, const std::string& file);

}  // namespace plumbline::control

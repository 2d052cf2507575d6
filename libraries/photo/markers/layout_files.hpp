// Files that say where tags are.
#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "plumbline/rigid_transform.hpp"

namespace plumbline::markers {

struct LayoutTag {
  std::string family;  ///< empty if the file does not say it
  int id = 0;
  double size = 0;                ///< [m]; 0 if the file does not say it
  RigidTransform world_from_tag;  ///< tag frame: centre, x right, y up, z out of it
};

/// Reads WPILib's field layout (JSON: tags with x out of the face and z up), our tags.json, ArUco's marker map
/// (aruco_bc_markers with four corners each, clockwise from the top left) or a CSV table with the columns tag_id, x_m,
/// y_m, z_m (or _mm), optionally tag_family, tag_size_m, tag_x/y/z_m (centre of the tag seen from the point), and its
/// rotation as qw, qx, qy, qz (world from tag) or facing_azimuth_deg (direction of the normal, clockwise from y, the
/// tag upright). Throws std::runtime_error that names file and line.
std::vector<LayoutTag> parse_layout(const std::string& text, const std::string& file);

}  // namespace plumbline::markers

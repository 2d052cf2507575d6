// Surveyed points and where they are in photographs, from tables.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace plumbline::markers {

struct ControlPoint {
  std::string name;
  Eigen::Vector3d position;  ///< [m]
  Eigen::Vector3d sigma;     ///< [m]; nan where the file says none
  bool check = false;        ///< withheld, to judge by
};

struct ImagePoint {
  std::string image, point;
  Eigen::Vector2d pixel;  ///< the centre of the top-left pixel is (0, 0)
  double sigma = 0;       ///< [px]; 0: not said
};

/// Surveyed points from CSV (name, x, y, z or east, north, height; optionally sigma or sigma_x, sigma_y, sigma_z, and
/// role: control or check) or from OpenDroneMap's gcp_list.txt. Throws std::runtime_error that names file and line.
std::vector<ControlPoint> parse_control(const std::string& text, const std::string& file);

/// Whether a control file says which coordinate is east: by columns east, easting, e (or north, northing, n), or as a
/// gcp_list.txt, where x is. Columns x and y are either, by country and program.
bool says_which_is_east(const std::string& text, const std::string& file);

/// Their measurements from CSV (image, point, x, y, optionally sigma), observations.json of a detector (the centre of a
/// tag is point "id"), or gcp_list.txt. `corner_origin`: the file has the corner of the top-left pixel at (0, 0).
std::vector<ImagePoint> parse_image_points(const std::string& text, const std::string& file, bool corner_origin);

/// OpenDroneMap's gcp_list.txt; `projection` is its first line, such as "EPSG:32632".
std::string gcp_list(const std::vector<ControlPoint>& control, const std::vector<ImagePoint>& measured,
                     const std::string& projection);

}  // namespace plumbline::markers

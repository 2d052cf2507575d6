// Where known points were measured in photographs, from tables.
#pragma once

#include <string>
#include <vector>

#include "control/points/control_point.hpp"

namespace plumbline::control {

/// Measurements from CSV (image, point, x, y, optionally sigma), observations.json of a detector (the centre of a tag
/// is point "id"), or gcp_list.txt. `corner_origin`: the file has the corner of the top-left pixel at (0, 0). Throws
/// std::runtime_error that names file and line.
std::vector<ImagePoint> parse_image_points(const std::string& text, const std::string& file, bool corner_origin);

/// OpenDroneMap's gcp_list.txt; `projection` is its first line, such as "EPSG:32632".
std::string gcp_list(const std::vector<ControlPoint>& control, const std::vector<ImagePoint>& measured,
                     const std::string& projection);

}  // namespace plumbline::control

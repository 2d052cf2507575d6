// Which photographs of a board calibrate which camera.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "artifacts/board_points.hpp"
#include "photo/markers/calibration.hpp"

namespace plumbline::markers {

/// The photographs of one camera that take part, and why others don't.
struct Selection {
  std::string camera;  ///< folder or beginning of the names; empty if there is one camera
  std::vector<CalibrationView> views;
  std::vector<std::pair<std::string, std::string>> left_out;  ///< path, reason
  int width = 0, height = 0;
  std::string board;
};

/// One entry a camera, told apart as cameras::camera_name does; a camera with fewer than three usable photographs
/// beside one with more only stands in the `left_out` of the first.
std::vector<Selection> select(const std::vector<BoardPointsT>& photographs, const std::string& cameras);

}  // namespace plumbline::markers

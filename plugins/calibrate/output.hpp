// What a calibration gives, as files.
#pragma once

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "selection.hpp"

namespace plumbline::markers {

constexpr int map_columns = 25, map_rows = 19;  ///< of the maps over the image

/// Every other photograph against the rest.
struct Halves {
  double difference = std::nan(""), expected = std::nan("");  ///< medians over the image [px]
};

/// What one camera gave.
struct Calibrated {
  Selection selection;
  Calibration calibration;
  Halves halves;
};

std::vector<std::string> warnings_of(const Selection& selection, const Calibration& c, const Halves& halves);

/// calibration.json of one camera.
nlohmann::ordered_json calibration_json(const Selection& selection, const Calibration& c, const Halves& halves);

/// How the cameras stand to each other, from one adjustment of all photographs, `by` as in camera_name; what
/// contradicts itself becomes a warning.
nlohmann::ordered_json rig_json(const std::vector<Calibrated>& cameras, const std::string& by,
                                const CalibrationOptions& options, std::vector<std::string>& warnings);

/// One camera as it is; several each under its name, as read.camera takes them with `which`.
std::string yaml_of(const std::vector<Calibrated>& cameras, const std::string& id);

}  // namespace plumbline::markers

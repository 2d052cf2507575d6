// What a calibration gives, as files.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "photo/markers/calibration_parts.hpp"
#include "selection.hpp"

namespace plumbline::markers {

/// What one camera gave.
struct Calibrated : JudgedCalibration {
  Selection selection;
};

std::vector<std::string> warnings_of(const Calibrated& one);

/// calibration.json of one camera.
nlohmann::ordered_json calibration_json(const Calibrated& one);

/// How the cameras stand to each other, from one adjustment of all photographs, `by` as in camera_name; what
/// contradicts itself becomes a warning.
nlohmann::ordered_json rig_json(const std::vector<Calibrated>& cameras, const std::string& by,
                                const CalibrationOptions& options, std::vector<std::string>& warnings);

/// One camera as it is; several each under its name, as read.camera takes them with `which`.
std::string yaml_of(const std::vector<Calibrated>& cameras, const std::string& id);

}  // namespace plumbline::markers

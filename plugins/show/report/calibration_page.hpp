// The page of a calibration: parameters, residuals, coverage and the uncertainty of a projection over the image.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "show/report/markup.hpp"

namespace plumbline::report {

/// The body of the page from a calibration.json (docs/camera_calibration.md has its fields).
void write_calibration(Markup& html, const nlohmann::ordered_json& calibration, const std::string& title,
                       const std::string& subtitle);

}  // namespace plumbline::report

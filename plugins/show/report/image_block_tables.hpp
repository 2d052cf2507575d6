// The tables of an image block's page, one section each.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "show/report/markup.hpp"

namespace plumbline::report {

/// Interior orientation of each camera: values, standard deviations, strong correlations, residuals over the image.
void write_cameras(Markup& html, const nlohmann::ordered_json& block);
/// Every photograph: residuals, coverage, the largest angle of its rays with others, its place, or why it has none.
void write_images(Markup& html, const nlohmann::ordered_json& block);
void write_points(Markup& html, const nlohmann::ordered_json& block);
/// Control and check points, adjusted minus surveyed; nothing if none was surveyed.
void write_control(Markup& html, const nlohmann::ordered_json& block);
/// Every observation that was left out, and why.
void write_rejected(Markup& html, const nlohmann::ordered_json& block);

}  // namespace plumbline::report

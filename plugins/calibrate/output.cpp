#include "output.hpp"

#include <algorithm>
#include <array>
#include <sstream>

#include "markers/camera_files.hpp"
#include "markers/camera_groups.hpp"
#include "markers/rig.hpp"

namespace plumbline::markers {

using Json = nlohmann::ordered_json;

namespace {

Json grid_json(const std::vector<double>& values) {
  Json table = Json::array();
  for (int row = 0; row < map_rows; ++row) {
    Json line = Json::array();
    for (int column = 0; column < map_columns; ++column)
      line.push_back(values[static_cast<size_t>(row * map_columns + column)]);
    table.push_back(line);
  }
  return table;
}

Json images_json(const Selection& selection, const Calibration& c) {
  Json images = Json::array();
  for (const auto& view : c.views) {
    const CalibrationView& given = selection.views[static_cast<size_t>(view.view)];
    double left = 1e9, right = -1e9, top = 1e9, bottom = -1e9;
    Json points = Json::array();
    for (size_t k = 0; k < view.points.size(); ++k) {
      const Eigen::Vector2d& p = given.points[static_cast<size_t>(view.points[k])].pixel;
      left = std::min(left, p.x()), right = std::max(right, p.x()), top = std::min(top, p.y()),
      bottom = std::max(bottom, p.y());
      points.push_back({p.x(), p.y(), view.residuals[k].x(), view.residuals[k].y()});
    }
    const double covered = view.points.empty() ? 0
                                               : (right - left) * (bottom - top) /
                                                     (static_cast<double>(selection.width) * selection.height);
    const RigidTransform& t = view.cam_from_board;
    images.push_back({{"path", given.path},
                      {"used", true},
                      {"reason", ""},
                      {"points", view.points.size()},
                      {"rms_px", view.rms},
                      {"coverage", covered},
                      {"tilt_deg", view.tilt * 180 / M_PI},
                      {"rotation", {t.rotation.w(), t.rotation.x(), t.rotation.y(), t.rotation.z()}},
                      {"translation", {t.translation.x(), t.translation.y(), t.translation.z()}},
                      {"residuals", points}});
  }
  for (const auto& [path, reason] : selection.left_out)
    images.push_back({{"path", path}, {"used", false}, {"reason", reason}});
  return images;
}

}  // namespace

std::vector<std::string> warnings_of(const Selection& selection, const Calibration& c, const Halves& halves) {
  std::vector<std::string> warnings;
  char text[400];
  if (halves.expected > 0 && halves.difference > 2.5 * halves.expected) {
    std::snprintf(
        text, sizeof text,
        "Two halves of the photographs give cameras that differ by %.3f px (median over the image) where their "
        "uncertainties make %.3f px expected: the model does not fit this lens or this board, and the standard "
        "deviations are too small by a factor of about %.1f",
        halves.difference, halves.expected, halves.difference / halves.expected);
    warnings.emplace_back(text);
  }
  double tilted = 0;
  for (const auto& view : c.views) tilted += view.tilt > 20 * M_PI / 180;
  if (tilted < 0.25 * static_cast<double>(c.views.size()))
    warnings.emplace_back(
        "Most photographs look straight at the board: the principal distance then hangs on the distance. Tilt "
        "the board by 30 to 50 degrees in half of them");
  if (c.held_flat)
    warnings.emplace_back(
        "The photographs are too much alike to tell a bend of the board from the lens: the board is taken as flat, and "
        "the standard deviations know nothing of a bend");
  // Coverage in a 4 × 4 grid of the image.
  std::array<int, 16> cells{};
  for (const auto& view : c.views)
    for (const int k : view.points) {
      const Eigen::Vector2d& p = selection.views[static_cast<size_t>(view.view)].points[static_cast<size_t>(k)].pixel;
      const int x = std::clamp(static_cast<int>(4 * p.x() / selection.width), 0, 3),
                y = std::clamp(static_cast<int>(4 * p.y() / selection.height), 0, 3);
      ++cells[static_cast<size_t>(4 * y + x)];
    }
  const auto empty = std::count_if(cells.begin(), cells.end(), [](int n) { return n < 5; });
  if (empty > 0) {
    std::snprintf(text, sizeof text,
                  "%d of 16 parts of the image hold hardly any point: the distortion there is a guess. Bring the board "
                  "into every corner",
                  static_cast<int>(empty));
    warnings.emplace_back(text);
  }
  if (c.bend_x_sigma > 0 && std::max(std::abs(c.bend_x) / c.bend_x_sigma, std::abs(c.bend_y) / c.bend_y_sigma) > 4) {
    std::snprintf(text, sizeof text,
                  "The board is bent: its middle stands %.2f mm (along x) and %.2f mm (along y) before its edges; this "
                  "is taken into account",
                  1e3 * c.bend_x, 1e3 * c.bend_y);
    warnings.emplace_back(text);
  }
  return warnings;
}

Json calibration_json(const Selection& selection, const Calibration& c, const Halves& halves) {
  Json parameters, sigmas, correlations = Json::array();
  const auto values = c.camera.parameters();
  for (size_t i = 0; i < values.size(); ++i) {
    const Eigen::Index k = static_cast<Eigen::Index>(i);
    parameters[BrownCamera::parameter_names[i]] = values[i];
    sigmas[BrownCamera::parameter_names[i]] = std::sqrt(c.covariance(k, k));
    Json row = Json::array();
    for (Eigen::Index j = 0; j < 9; ++j) {
      const double scale = std::sqrt(c.covariance(k, k) * c.covariance(j, j));
      row.push_back(scale > 0 ? c.covariance(k, j) / scale : (k == j ? 1.0 : 0.0));
    }
    correlations.push_back(row);
  }
  Json rejected = Json::array(), warnings = Json::array(), covariance = Json::array();
  for (const auto& text : c.rejected) rejected.push_back(text);
  for (const auto& text : warnings_of(selection, c, halves)) warnings.push_back(text);
  for (Eigen::Index i = 0; i < 9; ++i)
    for (Eigen::Index j = 0; j <= i; ++j) covariance.push_back(c.covariance(i, j));
  return {
      {"board", selection.board},
      {"width", selection.width},
      {"height", selection.height},
      {"model", "Brown, as OpenCV: fx, fy, cx, cy, k1, k2, k3, p1, p2; the centre of the top-left pixel is (0, 0)"},
      {"parameters", parameters},
      {"sigmas", sigmas},
      {"parameter_order",
       std::vector<std::string>(BrownCamera::parameter_names.begin(), BrownCamera::parameter_names.end())},
      {"correlations", correlations},
      {"covariance_lower_triangle", covariance},
      {"rms_px", c.rms},
      {"sigma_px", c.sigma},
      {"observations", c.observations},
      {"unknowns", c.unknowns},
      {"degrees_of_freedom", c.degrees_of_freedom},
      {"board_bend_m", {c.bend_x, c.bend_y}},
      {"board_bend_sigma_m", {c.bend_x_sigma, c.bend_y_sigma}},
      {"halves", {{"median_difference_px", halves.difference}, {"median_expected_px", halves.expected}}},
      {"projection_uncertainty_px", grid_json(projection_uncertainty(c.camera, c.covariance, map_columns, map_rows))},
      {"warnings", warnings},
      {"rejected", rejected},
      {"images", images_json(selection, c)}};
}

Json rig_json(const std::vector<Calibrated>& cameras, const std::string& by, std::vector<std::string>& warnings) {
  std::vector<std::vector<RigView>> views;
  for (const auto& one : cameras) {
    views.emplace_back();
    for (const auto& view : one.calibration.views) {
      const std::string& path = one.selection.views[static_cast<size_t>(view.view)].path;
      views.back().push_back({moment_of(path), view.cam_from_board});
    }
  }
  Json rig = Json::array();
  if (by == "one") return rig;
  for (const RigPose& pose : rig_of(views)) {
    const auto name = [&](int k) { return cameras[static_cast<size_t>(k)].selection.camera; };
    const RigidTransform& t = pose.cam_from_reference;
    rig.push_back(
        {{"camera", name(pose.camera)},
         {"reference", name(pose.reference)},
         {"rotation", {t.rotation.w(), t.rotation.x(), t.rotation.y(), t.rotation.z()}},
         {"translation", {t.translation.x(), t.translation.y(), t.translation.z()}},
         {"rotation_sigma", {pose.rotation_sigma.x(), pose.rotation_sigma.y(), pose.rotation_sigma.z()}},
         {"translation_sigma", {pose.translation_sigma.x(), pose.translation_sigma.y(), pose.translation_sigma.z()}},
         {"rotation_scatter", pose.rotation_scatter},
         {"translation_scatter", pose.translation_scatter},
         {"moments", pose.moments},
         {"left_out", pose.left_out}});
    if (!pose.left_out.empty())
      warnings.push_back("Cameras " + name(pose.reference) + " and " + name(pose.camera) +
                         " do not stand to each other in " + std::to_string(pose.left_out.size()) +
                         " of their common photographs as in the others (the first is number " + pose.left_out.front() +
                         "): not taken at the same moment, or the rig moved");
  }
  return rig;
}

std::string yaml_of(const std::vector<Calibrated>& cameras, const std::string& id) {
  std::string text;
  for (const auto& one : cameras) {
    const std::string name = cameras.size() == 1 ? id : one.selection.camera;
    const std::string own = camera_yaml({name, one.calibration.camera, one.calibration.covariance, ""});
    if (cameras.size() == 1) return own;
    std::string quoted = name;
    for (size_t at = 0; (at = quoted.find_first_of("\"\\", at)) != std::string::npos; at += 2) quoted.insert(at, "\\");
    text += "\"" + quoted + "\":\n";
    std::istringstream lines(own);
    for (std::string line; std::getline(lines, line);) text += "  " + line + "\n";
  }
  return text;
}

}  // namespace plumbline::markers

// What a rig of cameras gives, for calibration.json.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "output.hpp"
#include "photo/cameras/camera_groups.hpp"
#include "photo/markers/rig_adjustment.hpp"

namespace plumbline::markers {

using Json = nlohmann::ordered_json;

namespace {

Json triple(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

Json pose_json(const AdjustedRig& rig, const AdjustedRigCamera& c, const std::vector<Calibrated>& cameras,
               const std::vector<std::vector<std::string>>& moments) {
  const auto& own = cameras[c.camera];
  const auto& views = own.selection.views;
  std::vector<std::string> left_out;
  for (const auto& path : rig.left_out)
    for (size_t i = 0; i < views.size(); ++i)
      if (views[i].path == path) left_out.push_back(moments[c.camera][i]);
  Json covariance = Json::array(), parameters, sigmas;
  for (Eigen::Index i = 0; i < 6; ++i)
    for (Eigen::Index j = 0; j <= i; ++j) covariance.push_back(c.covariance(i, j));
  const auto values = c.interior.parameters();
  const auto names = c.interior.names();
  for (size_t k = 0; k < names.size(); ++k) {
    const Eigen::Index i = static_cast<Eigen::Index>(k);
    parameters[names[k]] = values[k];
    sigmas[names[k]] = std::sqrt(c.interior_covariance(i, i));
  }
  const RigidTransform& t = c.cam_from_reference;
  const Eigen::Matrix<double, 6, 1> sigma = c.covariance.diagonal().cwiseSqrt();
  return {{"camera", own.selection.camera},
          {"reference", cameras[rig.reference].selection.camera},
          {"rotation", {t.rotation.w(), t.rotation.x(), t.rotation.y(), t.rotation.z()}},
          {"translation", triple(t.translation)},
          {"rotation_sigma", triple(sigma.head<3>())},
          {"translation_sigma", triple(sigma.tail<3>())},
          {"covariance_lower_triangle", covariance},
          {"halves", c.halves},
          {"rms_px", c.rms},
          {"separate_rms_px", c.separate_rms},
          {"shared", c.shared},
          {"moments", moments[c.camera]},
          {"left_out", left_out},
          {"parameters", parameters},
          {"sigmas", sigmas}};
}

void add_rig_warnings(const AdjustedRig& rig, const std::vector<Calibrated>& cameras,
                      std::vector<std::string>& warnings) {
  if (!rig.left_out.empty())
    warnings.push_back("Left out of the rig: photographs that do not show the board where the rig has it (" +
                       std::to_string(rig.left_out.size()) + ", the first is " + rig.left_out.front() +
                       "): not taken at the same moment as the others of their number, or the rig moved");
  if (!rig.held.empty())
    warnings.push_back("The rig is adjusted with " + rig.held +
                       " held as the cameras' own calibrations have them, because these photographs do not determine "
                       "them together; its standard deviations do not hold their uncertainty");
  double separate = 0;
  for (const auto& c : rig.cameras) separate = std::max(separate, c.separate_rms);
  if (rig.rms > 2.5 * separate) {
    const std::string text = fmt::format(
        "As a rig the photographs fit to {:.2f} px where each camera alone fits to {:.2f} px: those of one moment were "
        "not taken at quite the same time, or the cameras moved a little. The standard deviations of the rig are made "
        "of the larger residuals",
        rig.rms, separate);
    warnings.emplace_back(text);
  }
  for (const auto& c : rig.cameras)
    if (c.halves > 3) {
      warnings.push_back(
          fmt::format("Two halves of the moments place camera {} {:.1f} times as far apart as their standard "
                      "deviations make expected: the cameras moved against each other, or lens and board are not as "
                      "the model has them. Take the standard deviations that many times",
                      cameras[c.camera].selection.camera, std::sqrt(c.halves)));
    }
}

}  // namespace

Json rig_json(const std::vector<Calibrated>& cameras, const std::string& by, const CalibrationOptions& options,
              std::vector<std::string>& warnings) {
  Json result = Json::array();
  if (by == "one") return result;
  std::vector<RigCamera> given;
  std::vector<std::vector<std::string>> paths;
  for (const auto& one : cameras) {
    given.push_back({one.selection.camera, &one.selection.views, &one.calibration});
    paths.emplace_back();
    for (const auto& view : one.selection.views) paths.back().push_back(view.path);
  }
  const auto moments = cameras::moments_of(paths, by);
  for (const AdjustedRig& rig : adjust_rigs(given, moments, options)) {
    if (!rig.refused.empty()) {
      warnings.push_back("No rig: " + rig.refused +
                         ". Each camera is calibrated by itself. Photographs of one moment need the same last number "
                         "in their names, or a folder of their own");
      continue;
    }
    for (const auto& camera : rig.cameras)
      if (camera.camera != rig.reference) result.push_back(pose_json(rig, camera, cameras, moments));
    add_rig_warnings(rig, cameras, warnings);
  }
  return result;
}

}  // namespace plumbline::markers

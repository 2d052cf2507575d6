// camera.yaml of a campaign folder. Here, because its errors name the campaign's files.
#include <limits>
#include <numbers>

#include "campaign_yaml.hpp"
#include "geometry/camera_correlations.hpp"

namespace plumbline::campaign {

CameraCalibration parse_camera(const std::string& yaml, const std::filesystem::path& shown) {
  const YAML::Node root = load_yaml(yaml, shown);
  const Mapping mapping(root, shown,
                        {"plumbline_camera", "id", "make", "model", "width", "height", "pixel_pitch_um", "pixel_origin",
                         "lens", "parameters", "sigmas", "correlations"});
  mapping.require_version("plumbline_camera");
  CameraCalibration c;
  c.id = mapping.as<std::string>("id", "a name");
  if (mapping.has("make")) c.make = mapping.as<std::string>("make", "a text");
  if (mapping.has("model")) c.model = mapping.as<std::string>("model", "a text");
  c.pixel_pitch = mapping.has("pixel_pitch_um") ? 1e-6 * mapping.number("pixel_pitch_um")
                                                : std::numeric_limits<double>::quiet_NaN();
  c.camera.width = mapping.as<int>("width", "a whole number of pixels");
  c.camera.height = mapping.as<int>("height", "a whole number of pixels");
  if (c.camera.width <= 0 || c.camera.height <= 0)
    mapping.fail(mapping.get("width"), "the image size must be positive");

  if (mapping.has("lens")) {
    const std::string given = mapping.as<std::string>("lens", "brown or fisheye");
    const auto lens = lens_called(given);
    if (!lens) mapping.fail(mapping.get("lens"), "'lens' is '" + given + "', expected 'brown' or 'fisheye'");
    c.camera.lens = *lens;
  }
  const std::vector<std::string> names(c.camera.names().begin(), c.camera.names().end());
  const auto read = [&](const char* key, bool all_needed) {
    const Mapping values(mapping.get(key), shown, names);
    std::array<double, InteriorOrientation::parameter_count> numbers{};
    for (std::size_t i = 0; i < names.size(); ++i) {
      const bool needed = all_needed && i < 4;  // distortion that is not given is none
      if (needed || values.has(names[i])) numbers[i] = values.number(names[i]);
    }
    return numbers;
  };
  auto parameters = read("parameters", true);
  if (parameters[0] <= 0 || parameters[1] <= 0)
    mapping.fail(mapping.get("parameters"), "fx and fy must be positive (px)");
  const std::string origin = mapping.as<std::string>("pixel_origin", "centre or corner");
  if (origin != "centre" && origin != "corner") {
    mapping.fail(mapping.get("pixel_origin"),
                 "'pixel_origin' is '" + origin +
                     "', expected 'centre' (OpenCV: the centre of the top-left pixel is (0, 0)) "
                     "or 'corner' (COLMAP: it is (0.5, 0.5))");
  }
  if (origin == "corner") parameters[2] -= 0.5, parameters[3] -= 0.5;
  c.camera.set_parameters(parameters);
  if (mapping.has("sigmas")) c.sigmas = read("sigmas", false);
  for (const double sigma : c.sigmas) {
    if (sigma < 0) mapping.fail(mapping.get("sigmas"), "a standard deviation is negative");
  }
  CameraCorrelations correlations;
  if (mapping.has("correlations")) {
    const YAML::Node given = mapping.get("correlations");
    const Mapping rows(given, shown, names);
    for (std::size_t i = 0; i < names.size(); ++i)
      if (rows.has(names[i])) correlations[i] = rows.as<std::vector<double>>(names[i], "a list of numbers");
  }
  try {
    c.covariance = camera_covariance(c.camera.lens, c.sigmas, correlations);
  } catch (const std::runtime_error& error) {
    mapping.fail(mapping.get(mapping.has("correlations") ? "correlations" : "sigmas"), error.what());
  }
  return c;
}

Eigen::Quaterniond upright_plate(double facing_azimuth) {
  Eigen::Matrix3d axes;  // columns: the plate's x, y, z in E, N, H
  const Eigen::Vector3d normal(std::sin(facing_azimuth), std::cos(facing_azimuth), 0);
  axes.col(1) = Eigen::Vector3d::UnitZ();
  axes.col(2) = normal;
  axes.col(0) = axes.col(1).cross(normal);
  return Eigen::Quaterniond(axes);
}

}  // namespace plumbline::campaign

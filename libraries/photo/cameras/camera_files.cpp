#include "photo/cameras/camera_files.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "geometry/camera_correlations.hpp"
#include "photo/cameras/camera_file_values.hpp"
#include "photo/cameras/lens_names.hpp"

namespace plumbline::cameras {
namespace {

void read_size(const YAML::Node& root, const std::string& file, InteriorOrientation& camera) {
  const auto size = [&](const YAML::Node& node) {
    const auto value = camera_file::whole(node);
    if (!value) camera_file::refuse_value(file, node, "a number of pixels");
    return *value;
  };
  const YAML::Node width = camera_file::find(root, {"imagewidth", "width"}),
                   height = camera_file::find(root, {"imageheight", "height"});
  if (width.IsDefined() && height.IsDefined() && !width.IsNull() && !height.IsNull())
    camera.width = size(width), camera.height = size(height);
  const YAML::Node both = camera_file::find(root, {"imagesize", "imgsize", "resolution", "imageresolution"});
  if (camera.width || !both.IsDefined() || both.IsNull()) return;
  const auto values = camera_file::numbers(both);
  const auto w = values.size() == 2 ? camera_file::whole(values[0]) : std::nullopt,
             h = w ? camera_file::whole(values[1]) : std::nullopt;
  if (!h) camera_file::refuse_value(file, both, "width and height in pixels");
  camera.width = *w, camera.height = *h;
}

/// k1, k2, p1, p2, k3, ... in OpenCV's order; of a fisheye k1, k2, k3, k4.
void set_distortion(const std::vector<double>& d, const std::string& file, InteriorOrientation& camera) {
  if (camera.lens == LensModel::fisheye) {
    if (d.size() != 4)
      camera_file::refuse(
          file, "has " + std::to_string(d.size()) +
                    " coefficients of distortion, a fisheye (equidistant, Kannala-Brandt) has 4: k1, k2, k3, k4");
    camera.k1 = d[0], camera.k2 = d[1], camera.k3 = d[2], camera.k4 = d[3];
    return;
  }
  for (size_t i = 5; i < d.size(); ++i)
    if (std::abs(d[i]) > 1e-12)
      camera_file::refuse(
          file, "has " + std::to_string(d.size()) +
                    " distortion coefficients, of which the sixth and later are not zero; Brown's model has five: "
                    "k1, k2, p1, p2, k3. Calibrate without the rational model");
  const auto value = [&](size_t i) { return i < d.size() ? d[i] : 0.0; };
  camera.k1 = value(0), camera.k2 = value(1), camera.p1 = value(2), camera.p2 = value(3), camera.k3 = value(4);
}

/// By whole names: "ds" is a lens model, and a part of many cameras' names. What stands under `distortion_model` is
/// one, so a name that nobody knows is refused there; `camera_model` and `model` are often the camera's own name.
/// Returns the name of a model whose coefficients are not Brown's although they are called so, else nothing.
std::string read_lens(const YAML::Node& root, const std::string& file, InteriorOrientation& camera) {
  std::string not_quite_brown;
  for (const char* key : {"distortionmodel", "cameramodel", "model"}) {
    const YAML::Node model = camera_file::find(root, {key});
    if (!model.IsDefined() || !model.IsScalar()) continue;
    const std::string name = camera_file::simple(model.as<std::string>());
    const bool names_a_lens = std::string(key) == "distortionmodel" && !name.empty();
    const LensName lens = lens_named(name);
    if (lens == LensName::fisheye) camera.lens = LensModel::fisheye;
    if (lens == LensName::not_quite_brown) not_quite_brown = model.as<std::string>();
    // A fisheye of another model (COLMAP's RADIAL_FISHEYE), or none: Brown's would be a guess.
    const auto may_be_fisheye = [&](const char* part) { return name.find(part) != std::string::npos; };
    const bool is_doubtful = may_be_fisheye("fisheye") || may_be_fisheye("kannala") || may_be_fisheye("equidistant");
    if (lens == LensName::other || (lens == LensName::unknown && (names_a_lens || is_doubtful)))
      camera_file::refuse(file,
                          "the distortion model is '" + model.as<std::string>() +
                              "'; known are Brown's (plumb_bob, radtan) and the fisheye (equidistant, Kannala-Brandt)");
  }
  return not_quite_brown;
}

void read_opencv(const YAML::Node& root, const std::string& file, CameraFile& result) {
  const YAML::Node matrix = camera_file::find(root, {"cameramatrix", "camera", "cameraintrinsics", "intrinsicmatrix",
                                                     "k", "kmatrix", "mtx", "intrinsics", "intrinsic"});
  const auto k = camera_file::numbers(matrix);
  if (k.size() == 4 || k.size() == 9)
    for (const double value : k)
      if (std::isnan(value))
        camera_file::refuse_value(file, matrix, "the numbers of a camera matrix, or fx, fy, cx, cy");
  if (k.size() == 9) {
    if (std::abs(k[1]) > 1e-6 * std::abs(k[0]))
      camera_file::refuse(file, "the camera matrix has a skew, which Brown's model has not");
    result.camera.fx = k[0], result.camera.cx = k[2], result.camera.fy = k[4], result.camera.cy = k[5];
  } else if (k.size() == 4) {
    result.camera.fx = k[0], result.camera.fy = k[1], result.camera.cx = k[2], result.camera.cy = k[3];
  } else {
    const auto fx = camera_file::numbers(camera_file::find(root, {"fx"})),
               fy = camera_file::numbers(camera_file::find(root, {"fy"})),
               cx = camera_file::numbers(camera_file::find(root, {"cx"})),
               cy = camera_file::numbers(camera_file::find(root, {"cy"}));
    if (fx.size() != 1 || cx.size() != 1 || cy.size() != 1)
      camera_file::refuse(file, "no camera matrix found (" + std::to_string(k.size()) + " numbers, expected 9)");
    result.camera.fx = fx[0], result.camera.fy = fy.size() == 1 ? fy[0] : fx[0];
    result.camera.cx = cx[0], result.camera.cy = cy[0];
  }
  const std::string not_quite_brown = read_lens(root, file, result.camera);
  const YAML::Node fisheye = camera_file::find(root, {"fisheyemodel"});
  if (fisheye.IsDefined() && camera_file::whole(fisheye).value_or(0) != 0) result.camera.lens = LensModel::fisheye;
  const YAML::Node list = camera_file::find(root, {"distortioncoefficients", "distcoeffs", "distcoeff", "distortion",
                                                   "dist", "d", "distortioncoeffs", "cameradistortion", "distcoefs"});
  const auto d = camera_file::numbers(list);
  for (const double value : d)
    if (std::isnan(value)) camera_file::refuse_value(file, list, "the coefficients of distortion");
  if (!d.empty() && d.size() < 4)
    camera_file::refuse(
        file, "has " + std::to_string(d.size()) +
                  " coefficients of distortion, expected are 4 (k1, k2, p1, p2), 5 (and k3), or more; write zeros "
                  "where there are none");
  std::vector<double> named = d;
  if (d.empty()) {
    const std::vector<const char*> names = result.camera.lens == LensModel::fisheye
                                               ? std::vector<const char*>{"k1", "k2", "k3", "k4"}
                                               : std::vector<const char*>{"k1", "k2", "p1", "p2", "k3"};
    named.assign(names.size(), 0);
    for (size_t i = 0; i < names.size(); ++i) {
      const YAML::Node value = camera_file::find(root, {names[i]});
      if (value.IsDefined() && !value.IsNull()) named[i] = camera_file::number(value, file, names[i]);
    }
  }
  const bool distorts = std::any_of(named.begin(), named.end(), [](double v) { return v != 0; });
  if (!not_quite_brown.empty() && distorts)
    camera_file::refuse(
        file,
        "the distortion model is '" + not_quite_brown +
            "', whose coefficients are not those of Brown's: an inverse model leads from the distorted point to "
            "the ideal one (programs do not agree which way), the modified one takes decentring at the distorted "
            "point. Calibrate the camera from photographs (calibrate_camera); with all coefficients zero the file "
            "is taken");
  set_distortion(named, file, result.camera);
}

/// A mistyped name would leave its parameter at zero.
void refuse_unknown_names(const YAML::Node& map, LensModel lens, const std::string& of, const std::string& file) {
  for (const auto& entry : map) {
    const std::string name = entry.first.as<std::string>("");
    const auto names = InteriorOrientation::names_of(lens);
    if (std::find(names.begin(), names.end(), name) != names.end()) continue;
    std::string known;
    for (const char* each : names) known += (known.empty() ? "" : ", ") + std::string(each);
    camera_file::refuse(file, "line " + std::to_string(entry.first.Mark().line + 1) + ": '" + of + "' has no '" + name +
                                  "', only " + known);
  }
}

CameraCorrelations read_correlations(const YAML::Node& given, LensModel lens, const std::string& file) {
  CameraCorrelations rows;
  if (!given || given.IsNull()) return rows;
  if (!given.IsMap())
    camera_file::refuse_value(file, given, "a map of parameters and their correlations with those before them");
  refuse_unknown_names(given, lens, "correlations", file);
  const auto names = InteriorOrientation::names_of(lens);
  for (size_t i = 0; i < names.size(); ++i) {
    const YAML::Node row = given[names[i]];
    if (!row) continue;
    rows[i] = camera_file::numbers(row);
    for (const double value : rows[i])
      if (!std::isfinite(value)) camera_file::refuse_value(file, row, "numbers from -1 to 1");
  }
  return rows;
}

bool read_ours(const YAML::Node& root, const std::string& file, CameraFile& result) {
  if (!root["plumbline_camera"]) return false;
  result.format = "Plumbline";
  const YAML::Node parameters = root["parameters"], given = root["sigmas"];
  if (!parameters || !parameters.IsMap()) camera_file::refuse(file, "'parameters' is missing");
  if (const YAML::Node lens = root["lens"]) {
    const auto known = lens_called(lens.as<std::string>(""));
    if (!known) camera_file::refuse_value(file, lens, "the lens: brown or fisheye");
    result.camera.lens = *known;
  }
  const LensModel lens = result.camera.lens;
  const auto names = result.camera.names();
  refuse_unknown_names(parameters, lens, "parameters", file);
  if (given && !given.IsNull() && !given.IsMap())
    camera_file::refuse_value(file, given, "a map of parameters and their standard deviations");
  if (given && given.IsMap()) refuse_unknown_names(given, lens, "sigmas", file);
  std::array<double, InteriorOrientation::parameter_count> values{}, sigmas{};
  for (size_t i = 0; i < names.size(); ++i) {
    const char* name = names[i];
    const bool is_distortion = i >= 4;
    if (parameters[name])
      values[i] = camera_file::number(parameters[name], file, name);
    else if (!is_distortion)
      camera_file::refuse(file, std::string("'parameters' has no ") + name);
    if (given && given.IsMap() && given[name]) {
      sigmas[i] = camera_file::number(given[name], file, std::string("the standard deviation of ") + name);
      if (sigmas[i] < 0)
        camera_file::refuse_value(file, given[name], std::string("a standard deviation of ") + name + " of 0 or more");
    }
  }
  result.camera.set_parameters(values);
  if (root["pixel_origin"] && root["pixel_origin"].as<std::string>("") == "corner")
    result.camera.cx -= 0.5, result.camera.cy -= 0.5;
  const CameraCorrelations correlations = read_correlations(root["correlations"], lens, file);
  try {
    result.covariance = camera_covariance(lens, sigmas, correlations);
  } catch (const std::runtime_error& error) {
    camera_file::refuse(file, error.what());
  }
  return true;
}

/// Names of the cameras in a file that holds several: ours, or Kalibr's camchain (cam0, cam1, ...).
std::vector<std::string> names_of(const YAML::Node& root) {
  std::vector<std::string> names;
  if (root.IsMap() && !root["plumbline_camera"])
    for (const auto& entry : root)
      if (entry.second.IsMap()) {
        const std::string name = entry.first.as<std::string>("");
        const bool numbered = name.size() > 3 && name.rfind("cam", 0) == 0 &&
                              name.find_first_not_of("0123456789", 3) == std::string::npos;
        if (entry.second["plumbline_camera"] || entry.second["intrinsics"] || numbered) names.push_back(name);
      }
  return names;
}

bool is_kalibr(const YAML::Node& camera) { return camera.IsMap() && !camera["plumbline_camera"]; }

}  // namespace

CameraFile parse_camera_file(const std::string& text, const std::string& file, const std::string& which) {
  CameraFile result;
  YAML::Node root = camera_file::parse(text, file);
  if (!root.IsMap() && !root.IsSequence()) camera_file::refuse(file, "holds no keys");
  if (root.IsMap() && !which.empty()) {
    if (!root[which]) camera_file::refuse(file, "there is no '" + which + "' in it");
    root.reset(root[which]);
    if (is_kalibr(root) && root["intrinsics"]) result.format = "Kalibr", result.id = which;
  } else if (const auto held = names_of(root); held.size() == 1 && is_kalibr(root[held.front()])) {
    root.reset(root[held.front()]);
    result.format = "Kalibr", result.id = held.front();
  } else {
    std::string names;
    for (const auto& name : held) names += (names.empty() ? "'" : ", '") + name + "'";
    if (!names.empty())
      camera_file::refuse(
          file,
          "it holds several cameras; choose one with which=, or put the one that took the photographs into a "
          "file of its own: " +
              names);
  }
  const size_t slash = file.find_last_of('/');
  if (result.id.empty()) result.id = slash == std::string::npos ? file : file.substr(slash + 1);
  const YAML::Node id = root.IsMap() ? root["id"] : YAML::Node();
  if (id && id.IsScalar()) result.id = id.as<std::string>();
  const YAML::Node name = camera_file::find(root, {"cameraname"});
  if (name.IsDefined() && name.IsScalar()) result.id = name.as<std::string>();
  read_size(root, file, result.camera);
  if (!root.IsMap() || !read_ours(root, file, result)) {
    if (result.format.empty()) result.format = "OpenCV";
    read_opencv(root, file, result);
  }
  for (const double value : result.camera.parameters())
    if (!std::isfinite(value)) camera_file::refuse(file, "a parameter is not a number");
  if (!(result.camera.fx > 0 && result.camera.fy > 0))
    camera_file::refuse(file, "the principal distance (fx, fy) is not positive");
  const double extent = std::max(result.camera.width, result.camera.height);
  if (extent > 0 && (result.camera.fx < 0.05 * extent || result.camera.fx > 200 * extent))
    camera_file::refuse(file, "fx is " + std::to_string(result.camera.fx) + " px for an image of " +
                                  std::to_string(result.camera.width) + " x " + std::to_string(result.camera.height) +
                                  " px; the principal distance must be in pixels");
  return result;
}

std::vector<CameraFile> parse_camera_files(const std::string& text, const std::string& file, const std::string& which) {
  const std::vector<std::string> names =
      which.empty() ? names_of(camera_file::parse(text, file)) : std::vector<std::string>();
  if (names.empty()) return {parse_camera_file(text, file, which)};
  std::vector<CameraFile> cameras;
  for (const auto& name : names) {
    cameras.push_back(parse_camera_file(text, file, name));
    cameras.back().id = name;
  }
  return cameras;
}

Eigen::MatrixXd usual_covariance(const InteriorOrientation& camera) {
  Eigen::VectorXd sigma(9);
  const double f = 1e-3 * camera.fx;
  if (camera.lens == LensModel::fisheye)
    sigma << f, f, 2 * f, 2 * f, 0.01, 0.03, 0.05, 0.05, 0;
  else
    sigma << f, f, 2 * f, 2 * f, 0.01, 0.03, camera.k3 != 0 ? 0.05 : 0.0, 5e-4, 5e-4;
  return sigma.cwiseAbs2().asDiagonal();
}

}  // namespace plumbline::cameras

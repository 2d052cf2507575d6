#include "photo/markers/camera_files.hpp"

#include <fmt/core.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <pugixml.hpp>
#include <stdexcept>
#include <vector>

#include "base/text/one_document.hpp"
#include "geometry/camera_correlations.hpp"
#include "photo/markers/lens_names.hpp"

namespace plumbline::markers {
namespace {

[[noreturn]] void refuse(const std::string& file, const std::string& what) {
  throw std::runtime_error(
      file + ": " + what +
      ". A camera file is ours (plumbline_camera: 1), or one of OpenCV, ROS, Kalibr or PhotonVision "
      "with camera matrix and distortion coefficients");
}

/// An XML element as the YAML node of the same content.
YAML::Node node_of(const pugi::xml_node& element) {
  bool has_children = false;
  YAML::Node map(YAML::NodeType::Map);
  for (const auto& child : element.children())
    if (child.type() == pugi::node_element) map[child.name()] = node_of(child), has_children = true;
  if (has_children) return map;
  std::string text = element.child_value();
  std::vector<std::string> words;
  size_t at = 0;
  while ((at = text.find_first_not_of(" \t\r\n", at)) != std::string::npos) {
    const size_t end = std::min(text.find_first_of(" \t\r\n", at), text.size());
    words.push_back(text.substr(at, end - at));
    at = end;
  }
  if (words.size() == 1) return YAML::Node(words.front());
  YAML::Node list(YAML::NodeType::Sequence);
  for (const auto& word : words) list.push_back(word);
  return list;
}

YAML::Node parse(const std::string& text, const std::string& file) {
  const size_t first = text.find_first_not_of(" \t\r\n\xef\xbb\xbf");
  if (first == std::string::npos) refuse(file, "the file is empty");
  if (text[first] == '<') {
    pugi::xml_document document;
    const auto parsed = document.load_buffer(text.data(), text.size());
    if (!parsed) refuse(file, std::string("not well-formed XML (") + parsed.description() + ")");
    return node_of(document.document_element());
  }
  std::string body = text.substr(first);
  // OpenCV writes "%YAML:1.0", which is no YAML directive.
  if (body.rfind("%YAML", 0) == 0) body.erase(0, std::min(body.find('\n'), body.size()));
  try {
    return text::load_one_document(body);
  } catch (const YAML::Exception& error) {
    refuse(file, "neither YAML nor JSON nor XML (line " + std::to_string(error.mark.line + 1) + ": " + error.msg + ")");
  }
}

std::string simple(const std::string& key) {
  std::string name;
  for (const char c : key)
    if (std::isalnum(static_cast<unsigned char>(c)))
      name += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return name;
}

/// The first value under one of the names, wherever it stands; names in small letters without '_'.
YAML::Node find(const YAML::Node& node, const std::vector<std::string>& names, int depth = 0) {
  if (depth > 6 || !node.IsDefined()) return YAML::Node(YAML::NodeType::Undefined);
  if (node.IsMap()) {
    for (const auto& name : names)
      for (const auto& entry : node)
        if (entry.first.IsScalar() && simple(entry.first.as<std::string>()) == name) return entry.second;
    for (const auto& entry : node) {
      const YAML::Node found = find(entry.second, names, depth + 1);
      if (found.IsDefined() && !found.IsNull()) return found;
    }
  }
  if (node.IsSequence())
    for (const auto& item : node) {
      if (!item.IsMap()) continue;
      const YAML::Node found = find(item, names, depth + 1);
      if (found.IsDefined() && !found.IsNull()) return found;
    }
  return YAML::Node(YAML::NodeType::Undefined);
}

/// All numbers of a matrix, whether a list, a list of lists, or {rows, cols, data}.
std::vector<double> numbers(const YAML::Node& node) {
  std::vector<double> values;
  if (!node.IsDefined()) return values;
  if (node.IsMap()) {
    for (const char* name : {"data", "Data"})
      if (node[name]) return numbers(node[name]);
    return values;
  }
  if (node.IsScalar()) {
    try {
      values.push_back(node.as<double>());
    } catch (const YAML::Exception&) {
      values.push_back(std::nan(""));
    }
    return values;
  }
  for (const auto& item : node)
    for (const double v : numbers(item)) values.push_back(v);
  return values;
}

std::optional<int> whole(double value) {
  return value >= 0 && value < 1e6 ? std::optional(static_cast<int>(value)) : std::nullopt;
}

std::optional<int> whole(const YAML::Node& node) {
  const auto values = numbers(node);
  return values.size() == 1 ? whole(values[0]) : std::nullopt;
}

/// "line 4 has '[752, PNG480]', expected ..."
[[noreturn]] void refuse_value(const std::string& file, const YAML::Node& node, const std::string& expected) {
  YAML::Emitter out;
  out << YAML::Flow << node;
  std::string text = out.c_str() ? out.c_str() : "";
  if (text.size() > 60) text = text.substr(0, 57) + "...";
  refuse(file, "line " + std::to_string(node.Mark().line + 1) + " has '" + text + "', expected " + expected);
}

void read_size(const YAML::Node& root, const std::string& file, InteriorOrientation& camera) {
  const auto size = [&](const YAML::Node& node) {
    const auto value = whole(node);
    if (!value) refuse_value(file, node, "a number of pixels");
    return *value;
  };
  const YAML::Node width = find(root, {"imagewidth", "width"}), height = find(root, {"imageheight", "height"});
  if (width.IsDefined() && height.IsDefined() && !width.IsNull() && !height.IsNull())
    camera.width = size(width), camera.height = size(height);
  const YAML::Node both = find(root, {"imagesize", "imgsize", "resolution", "imageresolution"});
  if (camera.width || !both.IsDefined() || both.IsNull()) return;
  const auto values = numbers(both);
  const auto w = values.size() == 2 ? whole(values[0]) : std::nullopt, h = w ? whole(values[1]) : std::nullopt;
  if (!h) refuse_value(file, both, "width and height in pixels");
  camera.width = *w, camera.height = *h;
}

double number(const YAML::Node& node, const std::string& file, const std::string& of) {
  const auto values = numbers(node);
  if (values.size() != 1 || !std::isfinite(values[0])) refuse_value(file, node, "a number: " + of);
  return values[0];
}

/// k1, k2, p1, p2, k3, ... in OpenCV's order; of a fisheye k1, k2, k3, k4.
void set_distortion(const std::vector<double>& d, const std::string& file, InteriorOrientation& camera) {
  if (camera.lens == LensModel::fisheye) {
    if (d.size() != 4)
      refuse(file, "has " + std::to_string(d.size()) +
                       " coefficients of distortion, a fisheye (equidistant, Kannala-Brandt) has 4: k1, k2, k3, k4");
    camera.k1 = d[0], camera.k2 = d[1], camera.k3 = d[2], camera.k4 = d[3];
    return;
  }
  for (size_t i = 5; i < d.size(); ++i)
    if (std::abs(d[i]) > 1e-12)
      refuse(file, "has " + std::to_string(d.size()) +
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
    const YAML::Node model = find(root, {key});
    if (!model.IsDefined() || !model.IsScalar()) continue;
    const std::string name = simple(model.as<std::string>());
    const bool names_a_lens = std::string(key) == "distortionmodel" && !name.empty();
    const LensName lens = lens_named(name);
    if (lens == LensName::fisheye) camera.lens = LensModel::fisheye;
    if (lens == LensName::not_quite_brown) not_quite_brown = model.as<std::string>();
    // A fisheye of another model (COLMAP's RADIAL_FISHEYE), or none: Brown's would be a guess.
    const auto may_be_fisheye = [&](const char* part) { return name.find(part) != std::string::npos; };
    const bool is_doubtful = may_be_fisheye("fisheye") || may_be_fisheye("kannala") || may_be_fisheye("equidistant");
    if (lens == LensName::other || (lens == LensName::unknown && (names_a_lens || is_doubtful)))
      refuse(file, "the distortion model is '" + model.as<std::string>() +
                       "'; known are Brown's (plumb_bob, radtan) and the fisheye (equidistant, Kannala-Brandt)");
  }
  return not_quite_brown;
}

void read_opencv(const YAML::Node& root, const std::string& file, CameraFile& result) {
  const YAML::Node matrix = find(root, {"cameramatrix", "camera", "cameraintrinsics", "intrinsicmatrix", "k", "kmatrix",
                                        "mtx", "intrinsics", "intrinsic"});
  const auto k = numbers(matrix);
  if (k.size() == 4 || k.size() == 9)
    for (const double value : k)
      if (std::isnan(value)) refuse_value(file, matrix, "the numbers of a camera matrix, or fx, fy, cx, cy");
  if (k.size() == 9) {
    if (std::abs(k[1]) > 1e-6 * std::abs(k[0]))
      refuse(file, "the camera matrix has a skew, which Brown's model has not");
    result.camera.fx = k[0], result.camera.cx = k[2], result.camera.fy = k[4], result.camera.cy = k[5];
  } else if (k.size() == 4) {
    result.camera.fx = k[0], result.camera.fy = k[1], result.camera.cx = k[2], result.camera.cy = k[3];
  } else {
    const auto fx = numbers(find(root, {"fx"})), fy = numbers(find(root, {"fy"})), cx = numbers(find(root, {"cx"})),
               cy = numbers(find(root, {"cy"}));
    if (fx.size() != 1 || cx.size() != 1 || cy.size() != 1)
      refuse(file, "no camera matrix found (" + std::to_string(k.size()) + " numbers, expected 9)");
    result.camera.fx = fx[0], result.camera.fy = fy.size() == 1 ? fy[0] : fx[0];
    result.camera.cx = cx[0], result.camera.cy = cy[0];
  }
  const std::string not_quite_brown = read_lens(root, file, result.camera);
  const YAML::Node fisheye = find(root, {"fisheyemodel"});
  if (fisheye.IsDefined() && whole(fisheye).value_or(0) != 0) result.camera.lens = LensModel::fisheye;
  const YAML::Node list = find(root, {"distortioncoefficients", "distcoeffs", "distcoeff", "distortion", "dist", "d",
                                      "distortioncoeffs", "cameradistortion", "distcoefs"});
  const auto d = numbers(list);
  for (const double value : d)
    if (std::isnan(value)) refuse_value(file, list, "the coefficients of distortion");
  if (!d.empty() && d.size() < 4)
    refuse(file, "has " + std::to_string(d.size()) +
                     " coefficients of distortion, expected are 4 (k1, k2, p1, p2), 5 (and k3), or more; write zeros "
                     "where there are none");
  std::vector<double> named = d;
  if (d.empty()) {
    const std::vector<const char*> names = result.camera.lens == LensModel::fisheye
                                               ? std::vector<const char*>{"k1", "k2", "k3", "k4"}
                                               : std::vector<const char*>{"k1", "k2", "p1", "p2", "k3"};
    named.assign(names.size(), 0);
    for (size_t i = 0; i < names.size(); ++i) {
      const YAML::Node value = find(root, {names[i]});
      if (value.IsDefined() && !value.IsNull()) named[i] = number(value, file, names[i]);
    }
  }
  const bool distorts = std::any_of(named.begin(), named.end(), [](double v) { return v != 0; });
  if (!not_quite_brown.empty() && distorts)
    refuse(file,
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
    refuse(file, "line " + std::to_string(entry.first.Mark().line + 1) + ": '" + of + "' has no '" + name + "', only " +
                     known);
  }
}

CameraCorrelations read_correlations(const YAML::Node& given, LensModel lens, const std::string& file) {
  CameraCorrelations rows;
  if (!given || given.IsNull()) return rows;
  if (!given.IsMap()) refuse_value(file, given, "a map of parameters and their correlations with those before them");
  refuse_unknown_names(given, lens, "correlations", file);
  const auto names = InteriorOrientation::names_of(lens);
  for (size_t i = 0; i < names.size(); ++i) {
    const YAML::Node row = given[names[i]];
    if (!row) continue;
    rows[i] = numbers(row);
    for (const double value : rows[i])
      if (!std::isfinite(value)) refuse_value(file, row, "numbers from -1 to 1");
  }
  return rows;
}

bool read_ours(const YAML::Node& root, const std::string& file, CameraFile& result) {
  if (!root["plumbline_camera"]) return false;
  result.format = "Plumbline";
  const YAML::Node parameters = root["parameters"], given = root["sigmas"];
  if (!parameters || !parameters.IsMap()) refuse(file, "'parameters' is missing");
  if (const YAML::Node lens = root["lens"]) {
    const auto known = lens_called(lens.as<std::string>(""));
    if (!known) refuse_value(file, lens, "the lens: brown or fisheye");
    result.camera.lens = *known;
  }
  const LensModel lens = result.camera.lens;
  const auto names = result.camera.names();
  refuse_unknown_names(parameters, lens, "parameters", file);
  if (given && !given.IsNull() && !given.IsMap())
    refuse_value(file, given, "a map of parameters and their standard deviations");
  if (given && given.IsMap()) refuse_unknown_names(given, lens, "sigmas", file);
  std::array<double, InteriorOrientation::parameter_count> values{}, sigmas{};
  for (size_t i = 0; i < names.size(); ++i) {
    const char* name = names[i];
    const bool is_distortion = i >= 4;
    if (parameters[name])
      values[i] = number(parameters[name], file, name);
    else if (!is_distortion)
      refuse(file, std::string("'parameters' has no ") + name);
    if (given && given.IsMap() && given[name]) {
      sigmas[i] = number(given[name], file, std::string("the standard deviation of ") + name);
      if (sigmas[i] < 0)
        refuse_value(file, given[name], std::string("a standard deviation of ") + name + " of 0 or more");
    }
  }
  result.camera.set_parameters(values);
  if (root["pixel_origin"] && root["pixel_origin"].as<std::string>("") == "corner")
    result.camera.cx -= 0.5, result.camera.cy -= 0.5;
  const CameraCorrelations correlations = read_correlations(root["correlations"], lens, file);
  try {
    result.covariance = camera_covariance(lens, sigmas, correlations);
  } catch (const std::runtime_error& error) {
    refuse(file, error.what());
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
  YAML::Node root = parse(text, file);
  if (!root.IsMap() && !root.IsSequence()) refuse(file, "holds no keys");
  if (root.IsMap() && !which.empty()) {
    if (!root[which]) refuse(file, "there is no '" + which + "' in it");
    root.reset(root[which]);
    if (is_kalibr(root) && root["intrinsics"]) result.format = "Kalibr", result.id = which;
  } else if (const auto held = names_of(root); held.size() == 1 && is_kalibr(root[held.front()])) {
    root.reset(root[held.front()]);
    result.format = "Kalibr", result.id = held.front();
  } else {
    std::string names;
    for (const auto& name : held) names += (names.empty() ? "'" : ", '") + name + "'";
    if (!names.empty())
      refuse(file,
             "it holds several cameras; choose one with which=, or put the one that took the photographs into a "
             "file of its own: " +
                 names);
  }
  const size_t slash = file.find_last_of('/');
  if (result.id.empty()) result.id = slash == std::string::npos ? file : file.substr(slash + 1);
  const YAML::Node id = root.IsMap() ? root["id"] : YAML::Node();
  if (id && id.IsScalar()) result.id = id.as<std::string>();
  const YAML::Node name = find(root, {"cameraname"});
  if (name.IsDefined() && name.IsScalar()) result.id = name.as<std::string>();
  read_size(root, file, result.camera);
  if (!root.IsMap() || !read_ours(root, file, result)) {
    if (result.format.empty()) result.format = "OpenCV";
    read_opencv(root, file, result);
  }
  for (const double value : result.camera.parameters())
    if (!std::isfinite(value)) refuse(file, "a parameter is not a number");
  if (!(result.camera.fx > 0 && result.camera.fy > 0)) refuse(file, "the principal distance (fx, fy) is not positive");
  const double extent = std::max(result.camera.width, result.camera.height);
  if (extent > 0 && (result.camera.fx < 0.05 * extent || result.camera.fx > 200 * extent))
    refuse(file, "fx is " + std::to_string(result.camera.fx) + " px for an image of " +
                     std::to_string(result.camera.width) + " x " + std::to_string(result.camera.height) +
                     " px; the principal distance must be in pixels");
  return result;
}

std::vector<CameraFile> parse_camera_files(const std::string& text, const std::string& file, const std::string& which) {
  const std::vector<std::string> names = which.empty() ? names_of(parse(text, file)) : std::vector<std::string>();
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

namespace {

/// Lines that a reader skips.
std::string in_comment(const std::vector<std::string>& remarks) {
  std::string text;
  for (const std::string& remark : remarks) {
    text += "# ";
    for (const char c : remark) text += static_cast<unsigned char>(c) < 32 ? ' ' : c;
    text += "\n";
  }
  return text;
}

}  // namespace

std::string camera_yaml(const CameraFile& file) {
  const auto number = [](double value) { return fmt::format("{:.17g}", value); };
  std::string id;
  for (const char c : file.id) id += c == '"' || c == '\\' || static_cast<unsigned char>(c) < 32 ? '_' : c;
  std::string text = in_comment(file.remarks) + "plumbline_camera: 1\nid: \"" + id +
                     "\"\nwidth: " + std::to_string(file.camera.width) +
                     "\nheight: " + std::to_string(file.camera.height) +
                     "\npixel_origin: centre     # the centre of the top-left pixel is (0, 0), as OpenCV has it\n";
  text += file.camera.lens == LensModel::fisheye
              ? "lens: fisheye            # Kannala and Brandt, as OpenCV's fisheye, Kalibr's equidistant\n"
                "parameters:              # px; k1 to k4 of the angle off the axis\n"
              : "parameters:              # px; Brown's distortion, order and signs of OpenCV\n";
  const auto values = file.camera.parameters();
  const auto names = file.camera.names();
  const auto count = static_cast<Eigen::Index>(names.size());
  for (size_t i = 0; i < names.size(); ++i) text += std::string("  ") + names[i] + ": " + number(values[i]) + "\n";
  if (file.covariance.size() == 0) return text;
  text += "sigmas:                  # standard deviations; 0: held\n";
  for (Eigen::Index i = 0; i < count; ++i)
    text += std::string("  ") + names[i] + ": " + number(std::sqrt(std::max(0.0, file.covariance(i, i)))) + "\n";
  if (file.covariance.isDiagonal(0)) return text;
  text += "correlations:            # of each with those before it, in the order above\n";
  for (Eigen::Index i = 1; i < count; ++i) {
    text += std::string("  ") + names[i] + ": [";
    for (Eigen::Index j = 0; j < i; ++j) {
      const double scale = std::sqrt(file.covariance(i, i) * file.covariance(j, j));
      text += (j ? ", " : "") + (scale > 0 ? number(file.covariance(i, j) / scale) : "0");
    }
    text += "]\n";
  }
  return text;
}

}  // namespace plumbline::markers

#include "campaign_folder.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <limits>
#include <numbers>
#include <set>

#include "geometry/camera_correlations.hpp"
#include "images/photograph_header.hpp"

namespace plumbline::campaign {
namespace {

int line_of(const YAML::Node& node) { return node.Mark().line + 1; }

YAML::Node load(const std::string& yaml, const std::filesystem::path& shown) {
  try {
    return YAML::Load(yaml);
  } catch (const YAML::Exception& error) {
    throw CampaignError(shown, error.mark.line + 1, "this is no YAML: " + error.msg);
  }
}

std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t substituted = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, substituted});
    }
  }
  return row[b.size()];
}

std::string join(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

/// A mapping with known keys; every use of a wrong one is an error that names the nearest right one.
class Mapping {
 public:
  Mapping(const YAML::Node& node, const std::filesystem::path& shown, const std::vector<std::string>& known)
      : node_(node), shown_(shown) {
    if (!node.IsMap()) throw CampaignError(shown, 0, "found no mapping of keys, expected " + join(known));
    std::set<std::string> seen;
    for (const auto& entry : node) {
      if (!entry.first.IsScalar()) fail(entry.first, "a key must be a single word; known are " + join(known));
      const std::string key = entry.first.Scalar();
      if (!seen.insert(key).second) fail(entry.first, "'" + key + "' stands here a second time");
      if (std::find(known.begin(), known.end(), key) != known.end()) continue;
      const auto near = std::min_element(known.begin(), known.end(), [&](const auto& a, const auto& b) {
        return edit_distance(key, a) < edit_distance(key, b);
      });
      const bool close = edit_distance(key, *near) <= 2;
      fail(entry.first,
           "unknown key '" + key + "'" + (close ? ", did you mean '" + *near + "'?" : "; known are " + join(known)));
    }
  }

  [[noreturn]] void fail(const YAML::Node& at, const std::string& what) const {
    throw CampaignError(shown_, line_of(at), what);
  }
  YAML::Node get(const std::string& key) const {
    const YAML::Node value = node_[key];
    if (!value) throw CampaignError(shown_, line_of(node_), "the key '" + key + "' is missing");
    return value;
  }
  bool has(const std::string& key) const { return static_cast<bool>(node_[key]); }
  template <typename T>
  T as(const std::string& key, const char* expected) const {
    const YAML::Node value = get(key);
    try {
      return value.as<T>();
    } catch (const YAML::Exception&) {
      fail(value, "'" + key + "' is '" + (value.IsScalar() ? value.Scalar() : "(no single value)") + "', expected " +
                      expected);
    }
  }
  double number(const std::string& key) const {
    const double value = as<double>(key, "a number");
    if (!std::isfinite(value)) fail(get(key), "'" + key + "' is not a finite number");
    return value;
  }
  void require_version(const std::string& key) const {
    if (as<int>(key, "the version 1") != 1) fail(get(key), "this program reads version 1 of '" + key + "'");
  }

 private:
  YAML::Node node_;
  std::filesystem::path shown_;
};

bool matches(const char* pattern, const char* text) {
  if (!*pattern) return !*text;
  if (*pattern == '*') {
    for (const char* rest = text;; ++rest) {
      if (matches(pattern + 1, rest)) return true;
      if (!*rest || *rest == '/') return false;
    }
  }
  return *text && (*pattern == '?' ? *text != '/' : *pattern == *text) && matches(pattern + 1, text + 1);
}

class Resolver {
 public:
  Resolver(const Mapping& mapping, std::vector<std::string> files) : mapping_(mapping), files_(std::move(files)) {
    std::sort(files_.begin(), files_.end());
  }

  std::string one(const std::string& key) const {
    const std::vector<std::string> found = many(key);
    if (found.size() != 1) {
      mapping_.fail(mapping_.get(key),
                    "'" + key + "' matches " + std::to_string(found.size()) + " files, expected one");
    }
    return found.front();
  }

  /// A file, a pattern, or a list of them.
  std::vector<std::string> many(const std::string& key) const { return files_of(key, mapping_.get(key)); }

  std::vector<std::string> files_of(const std::string& key, const YAML::Node& node) const {
    std::vector<std::string> found;
    if (node.IsSequence()) {
      for (const YAML::Node& item : node) add(key, item, found);
    } else {
      add(key, node, found);
    }
    std::sort(found.begin(), found.end());
    found.erase(std::unique(found.begin(), found.end()), found.end());
    return found;
  }

 private:
  void add(const std::string& key, const YAML::Node& node, std::vector<std::string>& found) const {
    if (!node.IsScalar())
      mapping_.fail(node, "'" + key + "' must be a file, a pattern such as images/*.jpg, or a list");
    const std::string pattern = node.Scalar();
    const std::size_t before = found.size();
    for (const std::string& file : files_) {
      if (matches(pattern.c_str(), file.c_str())) found.push_back(file);
    }
    if (found.size() == before) {
      mapping_.fail(node, "'" + key + "' names '" + pattern +
                              "', and the folder has no such file; paths are relative to "
                              "campaign.yaml and upper and lower case differ");
    }
  }

  const Mapping& mapping_;
  std::vector<std::string> files_;
};

/// `camera` names one calibration, or of several which photographs each took. Those are added to `images`.
std::vector<CameraOfImages> parse_cameras(const Mapping& mapping, const Resolver& resolver, bool observed,
                                          std::vector<std::string>& images) {
  const YAML::Node node = mapping.get("camera");
  if (!node.IsMap()) return {{resolver.one("camera"), {}}};
  if (mapping.has("images"))
    mapping.fail(node,
                 "'camera' says which photographs each camera took, and 'images' names photographs too; take "
                 "'images' out");
  std::vector<CameraOfImages> cameras;
  for (const auto& entry : node) {
    const std::vector<std::string> files = resolver.files_of("camera", entry.first);
    if (files.size() != 1)
      mapping.fail(entry.first, "'" + entry.first.Scalar() + "' matches " + std::to_string(files.size()) +
                                    " files, expected one calibration");
    for (const CameraOfImages& other : cameras)
      if (other.file == files.front()) mapping.fail(entry.first, "'" + files.front() + "' stands here a second time");
    CameraOfImages camera{files.front(), {}};
    const auto add = [&](const YAML::Node& pattern) {
      if (!pattern.IsScalar())
        mapping.fail(pattern, "'camera': expected photographs of " + camera.file +
                                  ": a file, a pattern such as left/*.jpg, or a list");
      camera.patterns.push_back(pattern.Scalar());
    };
    if (entry.second.IsSequence())
      for (const YAML::Node& item : entry.second) add(item);
    else
      add(entry.second);
    if (camera.patterns.empty()) mapping.fail(entry.second, "'camera': no photographs are named for " + camera.file);
    if (!observed)  // measured tags carry the names of photographs that need not be there
      for (const std::string& image : resolver.files_of("camera", entry.second)) images.push_back(image);
    cameras.push_back(std::move(camera));
  }
  if (cameras.empty()) mapping.fail(node, "'camera' is an empty mapping, expected calibrations");
  std::sort(images.begin(), images.end());
  const auto twice = std::adjacent_find(images.begin(), images.end());
  if (twice != images.end()) mapping.fail(node, "'" + *twice + "' is named for two cameras, and was taken with one");
  return cameras;
}

}  // namespace

bool matches_pattern(const std::string& pattern, const std::string& name) {
  return matches(pattern.c_str(), name.c_str());
}

CampaignDescription parse_campaign(const std::string& yaml, const std::filesystem::path& shown,
                                   std::vector<std::string> files, CampaignUse use) {
  const Mapping mapping(load(yaml, shown), shown,
                        {"plumbline_campaign", "name", "images", "observations", "camera", "plates", "survey",
                         "instrument", "date", "control", "design", "mapping"});
  mapping.require_version("plumbline_campaign");
  const Resolver resolver(mapping, std::move(files));
  CampaignDescription c;
  if (mapping.has("name")) c.name = mapping.as<std::string>("name", "a text");
  if (mapping.has("instrument")) c.instrument = mapping.as<std::string>("instrument", "the name of a profile");
  if (mapping.has("date")) c.date = mapping.as<std::string>("date", "a day such as 2026-05-12");
  const bool optional = use == CampaignUse::photographs;
  const auto wanted = [&](const char* key) { return !optional || mapping.has(key); };
  if (wanted("survey")) c.survey = resolver.many("survey");
  if (mapping.has("control")) c.control = resolver.one("control");
  if (use == CampaignUse::survey) return c;
  if (c.survey.empty() && c.control.empty())
    throw CampaignError(shown, 0, "found neither 'survey' nor 'control': where the points are, nothing says");
  if (mapping.has("observations")) c.observations = resolver.one("observations");
  const bool by_camera = mapping.has("camera") && mapping.get("camera").IsMap();
  if (!by_camera && (c.observations.empty() || mapping.has("images"))) c.images = resolver.many("images");
  if (wanted("camera")) c.cameras = parse_cameras(mapping, resolver, !c.observations.empty(), c.images);
  if (optional && c.cameras.size() > 1)
    mapping.fail(mapping.get("camera"),
                 "several cameras are one camera.yaml here, each under the name of the folder of its photographs, or "
                 "none: photographs of a folder each calibrate themselves");
  if (wanted("plates")) c.plates = resolver.one("plates");
  if (optional) return c;
  c.design = resolver.one("design");
  if (mapping.has("mapping")) c.mapping = resolver.one("mapping");
  return c;
}

CampaignDescription find_campaign(const std::filesystem::path& folder, std::vector<std::string> files) {
  std::sort(files.begin(), files.end());
  CampaignDescription c;
  for (const std::string& file : files) {
    if (file == "camera.yaml") c.cameras = {{file, {}}};
    if (file == "plates.csv") c.plates = file;
    if (file == "control.csv") c.control = file;
    if (file.starts_with("survey/")) c.survey.push_back(file);
    if (is_photograph_name(file)) c.images.push_back(file);
  }
  const std::string mend = "; expected them by these names, or a campaign.yaml that says otherwise";
  if (c.images.empty()) throw CampaignError(folder, 0, "found no photograph (JPEG, PNG or TIFF) in this folder" + mend);
  if (c.survey.empty() && c.control.empty())
    throw CampaignError(folder, 0, "found no survey files in survey/ and no control.csv" + mend);
  return c;
}

CameraCalibration parse_camera(const std::string& yaml, const std::filesystem::path& shown) {
  const YAML::Node root = load(yaml, shown);
  const Mapping mapping(root, shown,
                        {"plumbline_camera", "id", "make", "model", "width", "height", "pixel_pitch_um", "pixel_origin",
                         "parameters", "sigmas", "correlations"});
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

  const std::vector<std::string> names(BrownCamera::parameter_names.begin(), BrownCamera::parameter_names.end());
  const auto read = [&](const char* key, bool all_needed) {
    const Mapping values(mapping.get(key), shown, names);
    std::array<double, BrownCamera::parameter_count> numbers{};
    for (std::size_t i = 0; i < numbers.size(); ++i) {
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
    c.covariance = camera_covariance(c.sigmas, correlations);
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

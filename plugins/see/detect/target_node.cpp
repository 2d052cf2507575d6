#include "target_node.hpp"

#include <fmt/core.h>

#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>

#include "artifacts/camera_artifact.hpp"
#include "base/text/csv_table.hpp"
#include "control/points/image_points.hpp"
#include "photo/cameras/camera_groups.hpp"
#include "photo/detect/target_fit.hpp"
#include "photo/images/grey_image.hpp"
#include "plumbline/stop.hpp"

namespace plumbline::detect {
namespace {

using Json = nlohmann::ordered_json;

struct Place {
  std::string point;
  Eigen::Vector2d pixel;
};
using Places = std::map<std::string, std::vector<Place>>;  // by Image.path

std::string base_name(const std::string& path) { return path.substr(path.find_last_of("/\\") + 1); }

/// Image.path by the names that files give photographs: the path, or its last part where only one ends so.
class Names {
 public:
  void add(const std::string& path) {
    paths_[path] = path;
    const auto [at, is_new] = by_base_.try_emplace(base_name(path), path);
    if (!is_new) at->second.clear();
  }
  std::optional<std::string> find(const std::string& name) const {
    if (const auto whole = paths_.find(name); whole != paths_.end()) return whole->second;
    const auto last = by_base_.find(base_name(name));
    if (last == by_base_.end() || last->second.empty()) return std::nullopt;
    return last->second;
  }

 private:
  std::map<std::string, std::string> paths_, by_base_;
};

Places from_file(Context& context, const FileT& file, const Names& names, bool corner_origin) {
  Places places;
  std::map<std::string, size_t> unknown;
  const std::string text(file.content.begin(), file.content.end());
  for (const auto& p : control::parse_image_points(text, file.name, corner_origin)) {
    const auto path = names.find(p.image);
    if (path)
      places[*path].push_back({p.point, p.pixel});
    else
      ++unknown[p.image];
  }
  for (const auto& [name, count] : unknown)
    context.warn(file.name + " has photograph " + name + " with " + std::to_string(count) +
                 (count == 1 ? " place" : " places") + ", but no photograph is called so, or several are");
  return places;
}

struct KnownCamera {
  std::string id;
  BrownCamera camera;
};

const BrownCamera& camera_for(const std::vector<KnownCamera>& cameras, const Image& photograph) {
  const std::string path = photograph.path()->str();
  const BrownCamera* found = cameras.size() == 1 ? &cameras.front().camera : nullptr;
  for (const auto& [id, camera] : cameras)
    if (!found && (id == cameras::folder_of(path) || (photograph.camera() && id == photograph.camera()->str())))
      found = &camera;
  if (!found)
    throw std::runtime_error(path + " is of none of the " + std::to_string(cameras.size()) +
                             " cameras: give one camera, or several that are called as the images' folders");
  if (found->width > 0 && (found->width != photograph.width() || found->height != photograph.height()))
    throw std::runtime_error(path + " has " + std::to_string(photograph.width()) + " x " +
                             std::to_string(photograph.height()) + " pixels, its camera " +
                             std::to_string(found->width) + " x " + std::to_string(found->height) +
                             ": give the photographs that the camera was calibrated on, unscaled and not rotated");
  return *found;
}

bool is_in(const Eigen::Vector2d& pixel, const Image& photograph) {
  return pixel.x() >= -0.5 && pixel.y() >= -0.5 && pixel.x() < photograph.width() - 0.5 &&
         pixel.y() < photograph.height() - 0.5;
}

/// Distortion polynomials turn back far outside the image and would bring points from there into it.
bool is_seen_so(const BrownCamera& camera, const Eigen::Vector3d& in_camera, const Eigen::Vector2d& pixel) {
  const auto back = unproject(camera, pixel);
  return back && (*back - in_camera.hnormalized()).norm() < 1e-6;
}

Json vector(const Eigen::Vector2d& v) { return {v.x(), v.y()}; }

const char* name_of(TargetKind kind) { return kind == TargetKind::quadrants ? "quadrants" : "crosshair"; }

Json entry_of(const Place& place, const MeasuredTarget& target) {
  Json entry = {{"point", place.point}, {"predicted", vector(place.pixel)}};
  if (target.problem.empty()) {
    const Eigen::Matrix2d& c = target.covariance;
    entry["kind"] = name_of(target.kind);
    entry["centre"] = vector(target.centre);
    entry["covariance"] = {c(0, 0), c(0, 1), c(1, 1)};
    entry["radius"] = target.radius, entry["blur"] = target.blur, entry["misfit"] = target.misfit;
  }
  entry["problem"] = target.problem;
  return entry;
}

FileT file_of(const char* name, const char* type, const std::string& text) {
  FileT file;
  file.name = name, file.media_type = type;
  file.content.assign(text.begin(), text.end());
  return file;
}

/// The rest of a row.
std::string numbers_of(std::initializer_list<double> values) {
  std::string text;
  for (const double value : values) {
    text += fmt::format(",{:.4f}", value);
  }
  return text + "\n";
}

}  // namespace

void PredictTargets::run(Context& context) {
  Names names;
  std::map<std::string, const Image*> photographs;
  for (size_t i = 0; i < images.size(); ++i)
    names.add(images[i].path()->str()), photographs[images[i].path()->str()] = &images[i];
  std::vector<KnownCamera> known;
  for (size_t i = 0; i < cameras.size(); ++i) known.push_back({cameras.unpack(i).id, camera_of(cameras.unpack(i))});
  const PointsT cloud = points.unpack();
  const PosesT oriented = poses.unpack();
  std::map<std::string, size_t> unknown;
  std::string rows = "image,point,x,y\n";
  size_t predicted = 0;
  for (const auto& pose : oriented.poses) {
    stop_point();
    const auto path = names.find(pose->path);
    if (!path) {
      ++unknown[pose->path];
      continue;
    }
    const Image& photograph = *photographs.at(*path);
    const BrownCamera& camera = camera_for(known, photograph);
    for (const auto& point : cloud.points) {
      if (!point->position.allFinite()) continue;
      const Eigen::Vector3d in_camera = pose->cam_from_world * point->position;
      const auto pixel = project(camera, in_camera);
      if (!pixel || !is_in(*pixel, photograph) || !is_seen_so(camera, in_camera, *pixel)) continue;
      rows += text::csv_field(*path) + "," + text::csv_field(point->id) + numbers_of({pixel->x(), pixel->y()});
      ++predicted;
    }
  }
  for (const auto& [name, count] : unknown)
    context.warn("'poses' has photograph " + name + ", but no photograph is called so, or several are");
  if (predicted == 0)
    throw std::runtime_error("none of the " + std::to_string(cloud.points.size()) + " points lies in any of the " +
                             std::to_string(oriented.poses.size()) +
                             " oriented photographs: points and poses are not of one frame, or of other photographs");
  context.metric("predicted", static_cast<double>(predicted), "1");
  places.commit(file_of("places.csv", "text/csv", rows));
}

void DetectTarget::run(Context& context) {
  Names names;
  std::map<std::string, const Image*> photographs;
  for (size_t i = 0; i < images.size(); ++i)
    names.add(images[i].path()->str()), photographs[images[i].path()->str()] = &images[i];
  const Places wanted = from_file(context, places.unpack(), names, *pixel_origin == "corner");
  const TargetFitOptions options{*kind == "any"         ? TargetKind::any
                                 : *kind == "quadrants" ? TargetKind::quadrants
                                                        : TargetKind::crosshair,
                                 *search, *max_radius, *min_contrast, *sigma_floor};
  std::string rows = "image,point,x,y,sigma\n";
  Json all = Json::array();
  size_t measured = 0, predicted = 0;
  for (const auto& [path, photograph] : photographs) {
    const auto here = wanted.find(path);
    stop_point();
    if (here == wanted.end()) continue;
    const GreyImage grey = read_grey_image(context.resolve(photograph->uri()->str()));
    Json entries = Json::array();
    for (const Place& place : here->second) {
      stop_point();
      const MeasuredTarget target = measure_target(grey, place.pixel, options);
      ++predicted;
      entries.push_back(entry_of(place, target));
      if (target.problem.empty())
        rows += text::csv_field(path) + "," + text::csv_field(place.point) +
                numbers_of({target.centre.x(), target.centre.y(), std::sqrt(0.5 * target.covariance.trace())}),
            ++measured;
      else
        context.warn(path + ": target " + place.point + " is not measured: " + target.problem);
    }
    all.push_back({{"path", path}, {"width", grey.width}, {"height", grey.height}, {"targets", entries}});
  }
  if (predicted == 0)
    throw std::runtime_error("no target is expected in any of the " + std::to_string(images.size()) +
                             " photographs: '" + places->name()->str() + "' names other photographs, or none");
  context.metric("predicted", static_cast<double>(predicted), "1");
  context.metric("measured", static_cast<double>(measured), "1");
  table.commit(file_of("targets.csv", "text/csv", rows));
  report.commit(file_of("targets.json", "application/json",
                        Json({{"images", all}}).dump(1, ' ', false, Json::error_handler_t::replace) + "\n"));
}

}  // namespace plumbline::detect

#include "photo/markers/control_targets.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

#include "base/text/words.hpp"

namespace plumbline::markers {
namespace {

/// Images by name, and by base name where that is unique.
std::map<std::string, std::uint32_t> names_of(const cameras::ColmapModel& model) {
  std::map<std::string, std::uint32_t> names;
  std::map<std::string, int> times;
  for (const auto& [id, image] : model.images) {
    const size_t slash = image.name.find_last_of('/');
    if (slash != std::string::npos)
      ++times[image.name.substr(slash + 1)], names.emplace(image.name.substr(slash + 1), id);
  }
  for (const auto& [name, count] : times)
    if (count > 1) names.erase(name);
  for (const auto& [id, image] : model.images) names[image.name] = id;
  return names;
}

}  // namespace

std::optional<Eigen::Vector3d> intersect(const cameras::ColmapModel& model, const std::vector<Measured>& rays) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const Measured& m : rays) {
    const cameras::ColmapImage& image = model.images.at(m.image);
    const auto q = unproject(model.cameras.at(image.camera).camera, m.pixel);
    if (!q) continue;
    const RigidTransform world_from_cam = image.cam_from_world.inverse();
    const Eigen::Vector3d d = (world_from_cam.rotation * q->homogeneous().eval()).normalized();
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - d * d.transpose();
    normal += across, right += across * world_from_cam.translation;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> spectrum(normal);
  if (rays.size() < 2 || spectrum.eigenvalues()(0) < 1e-5) return std::nullopt;
  return normal.ldlt().solve(right);
}

double largest_angle(const cameras::ColmapModel& model, const Eigen::Vector3d& point,
                     const std::vector<Measured>& rays) {
  double smallest = 1;
  for (size_t i = 0; i < rays.size(); ++i)
    for (size_t j = i + 1; j < rays.size(); ++j) {
      const auto direction = [&](const Measured& m) -> Eigen::Vector3d {
        return (model.images.at(m.image).cam_from_world.inverse().translation - point).normalized();
      };
      smallest = std::min(smallest, direction(rays[i]).dot(direction(rays[j])));
    }
  return std::acos(std::clamp(smallest, -1.0, 1.0));
}

std::vector<Target> targets_of(const cameras::ColmapModel& model, const std::vector<ControlPoint>& control,
                               const std::vector<ImagePoint>& measured, const ControlOptions& options,
                               ControlResult& result) {
  const auto names = names_of(model);
  std::vector<Target> targets;
  std::map<std::string, size_t> index;
  for (const ControlPoint& p : control)
    index[p.name] = targets.size(), targets.push_back({p.name, p.position, {}, &p, -1});
  std::set<std::string> unknown_images, unknown_points;
  std::set<std::pair<std::string, std::uint32_t>> seen;
  for (const ImagePoint& m : measured) {
    const size_t slash = m.image.find_last_of('/');
    auto image = names.find(m.image);
    if (image == names.end() && slash != std::string::npos) image = names.find(m.image.substr(slash + 1));
    const auto target = index.find(m.point);
    if (target == index.end()) {
      unknown_points.insert(m.point);
    } else if (image == names.end()) {
      unknown_images.insert(m.image);
    } else if (!seen.insert({m.point, image->second}).second) {
      result.warnings.push_back("point " + m.point + " is measured twice in " + m.image +
                                "; the first measurement is used");
    } else {
      targets[target->second].rays.push_back({image->second, m.pixel, m.sigma > 0 ? m.sigma : options.measured_sigma});
    }
  }
  const auto tell = [&](const std::set<std::string>& names_, const std::string& what) {
    if (names_.empty()) return;
    result.left_out.push_back(what + ": " + text::join({names_.begin(), names_.end()}, 8));
  };
  tell(unknown_images, "measurements in photographs that the model does not hold");
  tell(unknown_points, "measured points that are not in the control file");
  if (measured.size() && std::all_of(targets.begin(), targets.end(), [](const Target& t) { return t.rays.empty(); }))
    throw std::runtime_error(
        "no measurement belongs to a photograph of the model and a point of the control file. The model's photographs "
        "are called like " +
        model.images.begin()->second.name + " and the control points like " + control.front().name +
        "; the measurements name photographs like " + measured.front().image + " and points like " +
        measured.front().point);
  return targets;
}

void add_ties(const cameras::ColmapModel& model, const ControlOptions& options, std::vector<Target>& targets) {
  std::vector<std::pair<size_t, std::int64_t>> order;
  for (const auto& [id, point] : model.points)
    if (point.track.size() >= 2) order.emplace_back(point.track.size(), id);
  std::stable_sort(order.begin(), order.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  // Long tracks alone would leave photographs without ties: every photograph gets its share.
  std::map<std::uint32_t, int> held;
  const int share =
      std::max<int>(12, 3 * options.max_tie_points / std::max<int>(1, static_cast<int>(model.images.size())));
  std::set<std::int64_t> chosen;
  for (const auto& [length, id] : order) {
    if (static_cast<int>(chosen.size()) >= options.max_tie_points) break;
    const auto& track = model.points.at(id).track;
    if (std::none_of(track.begin(), track.end(), [&](const auto& t) { return held[t.first] < share; })) continue;
    chosen.insert(id);
    for (const auto& t : track) ++held[t.first];
  }
  for (const std::int64_t id : chosen) {
    const cameras::ColmapPoint& point = model.points.at(id);
    Target target{"tie " + std::to_string(id), point.position, {}, nullptr, id};
    std::set<std::uint32_t> images;
    for (const auto& [image, feature] : point.track)
      if (images.insert(image).second)
        target.rays.push_back({image, model.images.at(image).features[feature].pixel, options.tie_sigma});
    targets.push_back(target);
  }
}

}  // namespace plumbline::markers

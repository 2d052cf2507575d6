#include "photo/pose/rig.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <utility>

#include "photo/cameras/camera_groups.hpp"

namespace plumbline::pose {
namespace {

RigidTransform transform_of(const nlohmann::json& entry) {
  const auto& q = entry.at("rotation");
  const auto& t = entry.at("translation");
  const Eigen::Quaterniond rotation(q.at(0).get<double>(), q.at(1).get<double>(), q.at(2).get<double>(),
                                    q.at(3).get<double>());
  const Eigen::Vector3d translation(t.at(0).get<double>(), t.at(1).get<double>(), t.at(2).get<double>());
  if (!(std::abs(rotation.norm() - 1) < 1e-3) || !translation.allFinite())
    throw std::runtime_error("rotation is no unit quaternion w, x, y, z, or translation is not finite");
  return {rotation.normalized(), translation};
}

std::string names_of(const Rig& rig) {
  std::string names;
  for (const auto& [name, camera] : rig) names += (names.empty() ? "'" : ", '") + name + "'";
  return names;
}

/// The camera that a photograph names, or that of its folder or name.
const RigCamera& camera_of_photograph(const ImageTagsT& image, const Rig& rig) {
  for (const std::string& name :
       {image.camera, cameras::camera_name(image.path, "by_folder"), cameras::camera_name(image.path, "by_name"),
        cameras::camera_name(image.path, "by_file")})
    if (const auto found = rig.find(name); found != rig.end()) return found->second;
  throw std::runtime_error("image " + image.path + " is of " +
                           (image.camera.empty() ? "no camera that it names" : "camera '" + image.camera + "'") +
                           ", the rig has " + names_of(rig) +
                           "; expected is one of these as its camera, its folder or in its name");
}

}  // namespace

Rig parse_rig(const std::string& text, const std::string& file) {
  Rig rig;
  try {
    const auto root = nlohmann::json::parse(text);
    for (const auto& entry : root.at("rig")) {
      const std::string name = entry.at("camera"), reference = entry.at("reference");
      rig[reference] = {reference, RigidTransform()};
      if (!rig.emplace(name, RigCamera{reference, transform_of(entry)}).second)
        throw std::runtime_error("camera '" + name + "' stands in it twice");
    }
  } catch (const std::exception& error) {
    throw std::runtime_error(file + ": no rig (" + error.what() +
                             "); expected the calibration.json that calibrate_camera makes of several cameras, with "
                             "rig[] {camera, reference, rotation [w, x, y, z], translation [m]}");
  }
  if (rig.empty())
    throw std::runtime_error(file +
                             ": its rig is empty; the warnings of calibrate_camera say why the cameras could not be "
                             "tied together");
  return rig;
}

std::vector<Moment> moments_of(const std::vector<ImageTagsT>& images, const Rig& rig) {
  std::map<const RigCamera*, std::size_t> index;
  std::vector<std::vector<std::size_t>> of_camera;
  std::vector<std::vector<std::string>> paths;
  std::vector<std::string> all;
  for (std::size_t i = 0; i < images.size(); ++i) {
    const auto [at, is_new] = index.try_emplace(&camera_of_photograph(images[i], rig), of_camera.size());
    if (is_new) of_camera.emplace_back(), paths.emplace_back();
    of_camera[at->second].push_back(i), paths[at->second].push_back(images[i].path);
    all.push_back(images[i].path);
  }
  const auto names = cameras::moments_of(paths, cameras::cameras_told(all, "by_folder"));
  std::map<std::pair<std::string, std::string>, Moment> moments;  // by reference camera and name
  for (const auto& [camera, c] : index)
    for (std::size_t k = 0; k < of_camera[c].size(); ++k) {
      Moment& moment = moments[{camera->reference, names[c][k]}];
      moment.name = names[c][k];
      for (const RigPhotograph& other : moment.photographs)
        if (other.camera == camera)
          throw std::runtime_error("images " + images[other.image].path + " and " + paths[c][k] +
                                   " are both of one camera at moment " + moment.name +
                                   "; photographs taken together need the same last number in their names, others "
                                   "another one");
      moment.photographs.push_back({of_camera[c][k], camera});
    }
  std::vector<Moment> list;
  for (auto& [key, moment] : moments) {
    std::sort(moment.photographs.begin(), moment.photographs.end(),
              [](const auto& a, const auto& b) { return a.image < b.image; });
    list.push_back(std::move(moment));
  }
  std::sort(list.begin(), list.end(),
            [](const auto& a, const auto& b) { return a.photographs[0].image < b.photographs[0].image; });
  return list;
}

}  // namespace plumbline::pose

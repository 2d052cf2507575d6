#include "photograph_groups.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <stdexcept>
#include <tuple>

#include "base/text/words.hpp"
#include "photo/cameras/camera_groups.hpp"

namespace plumbline::markers {
namespace {

struct KeyOfImage {
  CameraKey key;
  double principal_distance = std::nan("");
};

/// A serial number tells bodies apart only where a model has several: programs drop it from some photographs.
std::vector<KeyOfImage> keys_of(const std::vector<ImageT>& images, const TagObservationsT& observations,
                                const std::vector<bool>& use, const std::string& by) {
  std::map<std::string, const ImageT*> header;
  for (const ImageT& image : images) header[image.path] = &image;
  std::vector<KeyOfImage> keys(observations.images.size());
  std::map<CameraKey, std::set<std::string>> bodies;
  std::vector<std::string> serials(keys.size());
  for (size_t i = 0; i < keys.size(); ++i) {
    const ImageTagsT& seen = *observations.images[i];
    const auto found = header.find(seen.path);
    CameraKey& key = keys[i].key;
    key.folder = cameras::camera_name(seen.path, by), key.width = seen.width, key.height = seen.height;
    if (found == header.end()) continue;
    const ImageT& image = *found->second;
    key.model = image.model;
    if (std::isfinite(image.focal_length)) key.focal_length = image.focal_length;
    keys[i].principal_distance = image.principal_distance;
    serials[i] = image.serial;
    if (use[i] && !image.serial.empty()) bodies[key].insert(image.serial);
  }
  for (size_t i = 0; i < keys.size(); ++i)
    if (const auto body = bodies.find(keys[i].key); body != bodies.end() && body->second.size() > 1)
      keys[i].key.serial = serials[i];
  return keys;
}

/// "Canon EOS R5 0123456, 24 mm": what EXIF says of a camera.
std::string words_of(const CameraKey& key) {
  std::string text = key.model.empty() ? "no EXIF" : key.model;
  if (!key.serial.empty()) text += " " + key.serial;
  if (key.focal_length > 0)
    text += ", " + std::to_string(static_cast<int>(std::lround(1000 * key.focal_length))) + " mm";
  return text;
}

MarkerCamera camera_from(const CameraGroup& group) {
  MarkerCamera camera;
  camera.id = !group.key.folder.empty() ? group.key.folder : !group.key.model.empty() ? group.key.model : "camera";
  if (!group.key.serial.empty()) camera.id += " " + group.key.serial;
  camera.camera.width = group.key.width, camera.camera.height = group.key.height;
  camera.source = "self-calibration, started from the shapes of the tags";
  if (std::isfinite(group.principal_distance)) {
    camera.camera.fx = camera.camera.fy = group.principal_distance;
    camera.camera.cx = 0.5 * (group.key.width - 1), camera.camera.cy = 0.5 * (group.key.height - 1);
    camera.source = "self-calibration, started from EXIF";
    if (group.key.focal_length > 0) camera.pixel_pitch = group.key.focal_length / group.principal_distance;
  }
  return camera;
}

/// Cameras of one folder, or without any name, are "images 1", "images 2".
void number_namesakes(std::vector<MarkerCamera>& cameras) {
  std::map<std::string, int> times, number;
  for (const MarkerCamera& camera : cameras) ++times[camera.id];
  for (MarkerCamera& camera : cameras)
    if (times[camera.id] > 1) {
      const std::string name = camera.id;
      camera.id += " " + std::to_string(++number[name]);
    }
}

}  // namespace

std::string size_text(int width, int height) { return std::to_string(width) + " x " + std::to_string(height); }

std::vector<CameraGroup> groups_of(const std::vector<ImageT>& images, const TagObservationsT& observations,
                                   const std::vector<bool>& use, const std::string& by) {
  const std::vector<KeyOfImage> keys = keys_of(images, observations, use, by);
  std::map<CameraKey, size_t> index;
  std::vector<CameraGroup> groups;
  for (size_t i = 0; i < keys.size(); ++i) {
    if (!use[i]) continue;
    const auto [at, is_new] = index.emplace(keys[i].key, groups.size());
    if (is_new) groups.push_back({keys[i].key, {}, keys[i].principal_distance});
    groups[at->second].images.push_back(i);
    if (!std::isfinite(groups[at->second].principal_distance))
      groups[at->second].principal_distance = keys[i].principal_distance;
  }
  return groups;
}

void drop_odd_groups(std::vector<CameraGroup>& groups, const TagObservationsT& observations, BlockInput& input) {
  constexpr size_t enough = 3;
  std::vector<CameraGroup> kept;
  for (const CameraGroup& group : groups) {
    const CameraGroup* large = nullptr;
    for (const CameraGroup& other : groups)
      if (other.key.folder == group.key.folder && other.images.size() >= enough &&
          other.images.size() > group.images.size())
        large = &other;
    if (group.images.size() >= enough || !large) {
      kept.push_back(group);
      continue;
    }
    const bool turned = group.key.width == large->key.height && group.key.height == large->key.width;
    const bool other_size = group.key.width != large->key.width || group.key.height != large->key.height;
    for (const size_t i : group.images) {
      std::string reason;
      if (turned)
        reason = "has " + size_text(group.key.width, group.key.height) + " pixels where the others have " +
                 size_text(large->key.width, large->key.height) +
                 ": a program turned its pixels. Use the file as the camera wrote it";
      else if (other_size)
        reason = "has " + size_text(group.key.width, group.key.height) + " pixels where the others have " +
                 size_text(large->key.width, large->key.height) +
                 ": it was resized, cropped or taken by another camera, and too few are like it to calibrate that one";
      else
        reason = "was taken with another camera or focal length (" + words_of(group.key) +
                 ") than the others, and too few are like it to calibrate it";
      input.left_out.push_back({observations.images[i]->path, reason});
    }
  }
  groups = kept;
}

std::vector<std::string> words_of_sizes(const std::vector<CameraGroup>& groups) {
  using Body = std::tuple<std::string, std::string, std::string>;
  std::map<Body, std::vector<std::pair<std::string, size_t>>> sizes;  // with the number of photographs
  for (const CameraGroup& group : groups) {
    auto& of_body = sizes[{group.key.folder, group.key.model, group.key.serial}];
    const std::string size = size_text(group.key.width, group.key.height);
    const auto known = std::find_if(of_body.begin(), of_body.end(), [&](const auto& one) { return one.first == size; });
    if (known == of_body.end())
      of_body.emplace_back(size, group.images.size());
    else
      known->second += group.images.size();
  }
  std::vector<std::string> words;
  for (const auto& [body, of_body] : sizes) {
    if (of_body.size() < 2) continue;
    std::vector<std::string> list;
    for (const auto& [size, count] : of_body) list.push_back(std::to_string(count) + " of " + size + " pixels");
    words.push_back("the photographs come in several sizes (" + text::enumerate(list, "; ", "; ") +
                    "): some were resized, cropped or turned by a program, or taken with another setting or by another "
                    "camera. Each size is calibrated as a camera of its own, from its photographs alone: if it is one "
                    "camera, use the files as it wrote them");
  }
  return words;
}

// Photographs without EXIF are taken for the calibrated camera's.
void drop_other_bodies(std::vector<CameraGroup> groups, const CameraT& known, const TagObservationsT& observations,
                       std::vector<bool>& use, BlockInput& input) {
  constexpr size_t few = 2;
  std::erase_if(groups, [](const CameraGroup& group) { return group.key.model.empty(); });
  if (groups.size() < 2) return;
  const auto larger = [](const CameraGroup& a, const CameraGroup& b) { return a.images.size() > b.images.size(); };
  std::stable_sort(groups.begin(), groups.end(), larger);
  if (groups[0].images.size() <= few || groups[1].images.size() > few) {
    std::string names;
    for (const CameraGroup& group : groups)
      names += (names.empty() ? "" : "; ") + words_of(group.key) + " (" + std::to_string(group.images.size()) +
               (group.images.size() == 1 ? " photograph)" : " photographs)");
    throw std::runtime_error("the calibration is of one camera, '" + known.id +
                             "', and by their EXIF the photographs are of " + std::to_string(groups.size()) + ": " +
                             names +
                             ". Give a folder and a calibration to each (docs/photographs.md), or no calibration at "
                             "all; cameras=one says that it is one camera all the same");
  }
  for (size_t g = 1; g < groups.size(); ++g)
    for (const size_t i : groups[g].images) {
      use[i] = false;
      input.left_out.push_back({observations.images[i]->path,
                                "was taken with another camera or focal length (" + words_of(groups[g].key) +
                                    ") than the others (" + words_of(groups[0].key) + "), and the calibration '" +
                                    known.id + "' is of one; cameras=one says that it is one camera all the same"});
    }
}

std::vector<MarkerCamera> cameras_of_groups(const std::vector<CameraGroup>& groups) {
  std::vector<MarkerCamera> cameras;
  for (const CameraGroup& group : groups) cameras.push_back(camera_from(group));
  number_namesakes(cameras);
  return cameras;
}

}  // namespace plumbline::markers

// The cameras of a block's photographs, by name.
#pragma once

#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "artifacts/camera_artifact.hpp"
#include "artifacts/image_tags.hpp"

namespace plumbline::pose {

class ImageCameras {
 public:
  /// The camera and its `others`. Throws std::runtime_error as camera_of(), and where two have one name.
  explicit ImageCameras(CameraT artifact) : given_(cameras_of(std::move(artifact))) {
    for (const CameraT& camera : given_) brown_.push_back(camera_of(camera));
  }

  std::size_t size() const { return given_.size(); }
  const CameraT& given(std::size_t camera) const { return given_[camera]; }
  const BrownCamera& brown(std::size_t camera) const { return brown_[camera]; }

  /// Which camera took the photograph by the name it carries; nothing if none has that name.
  std::optional<std::size_t> find(const ImageTagsT& image) const {
    if (given_.size() == 1) return 0;
    for (std::size_t c = 0; c < given_.size(); ++c)
      if (given_[c].id == image.camera) return c;
    return std::nullopt;
  }

  /// Which camera took the photograph: the only one, or that of the name the photograph carries. Throws
  /// std::runtime_error, without the image's path, if there is none of that name, or if the photograph has another
  /// size than its camera.
  std::size_t of(const ImageTagsT& image) const {
    const std::optional<std::size_t> found = find(image);
    if (!found) throw std::runtime_error("is of camera '" + image.camera + "', expected one of " + names());
    const std::size_t camera = *found;
    const BrownCamera& brown = brown_[camera];
    if (image.width > 0 && brown.width > 0 && (image.width != brown.width || image.height != brown.height))
      throw std::runtime_error("has " + std::to_string(image.width) + " x " + std::to_string(image.height) +
                               " pixels, camera '" + given_[camera].id + "' has " + std::to_string(brown.width) +
                               " x " + std::to_string(brown.height));
    return camera;
  }

 private:
  std::string names() const {
    std::string text;
    for (const CameraT& camera : given_) text += (text.empty() ? "'" : ", '") + camera.id + "'";
    return text;
  }

  std::vector<CameraT> given_;
  std::vector<BrownCamera> brown_;
};

}  // namespace plumbline::pose

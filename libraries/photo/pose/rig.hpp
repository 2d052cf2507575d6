// How the cameras of a rig stand to each other, as calibrate_camera found it, and which photographs were taken
// together.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "artifacts/image_tags.hpp"
#include "plumbline/rigid_transform.hpp"

namespace plumbline::pose {

struct RigCamera {
  std::string reference;  ///< camera whose frame is that of the rig
  RigidTransform cam_from_rig;
};

/// Cameras by name; the reference cameras are among them.
using Rig = std::map<std::string, RigCamera>;

/// `rig` of a calibration.json. Throws std::runtime_error with the file's name and what was expected.
Rig parse_rig(const std::string& text, const std::string& file);

struct RigPhotograph {
  std::size_t image = 0;      ///< index into the images
  const RigCamera* camera{};  ///< of the rig
};

/// Photographs of one rig at one moment, by the reference camera and the number in their names.
struct Moment {
  std::string name;
  std::vector<RigPhotograph> photographs;
};

/// In the order of their first photographs. A photograph is of the camera that it names, or of that of its folder or of
/// what stands around the number of its name. Throws std::runtime_error for a photograph of a camera that the rig does
/// not have, and for two of one camera at one moment.
std::vector<Moment> moments_of(const std::vector<ImageTagsT>& images, const Rig& rig);

}  // namespace plumbline::pose

// From the artifact of schemas/artifacts/camera.fbs to geometry/camera.hpp. For plugins: it needs the generated code.
#pragma once

#include <algorithm>
#include <array>
#include <stdexcept>
#include <string>

#include "artifacts/camera.hpp"
#include "geometry/camera.hpp"

namespace plumbline {

/// Throws std::runtime_error, naming the camera, unless it has nine parameters that say all of it, and positive
/// principal distances.
inline BrownCamera camera_of(const CameraT& artifact) {
  if (artifact.parameters.size() != BrownCamera::parameter_count)
    throw std::runtime_error("camera '" + artifact.id + "' has " + std::to_string(artifact.parameters.size()) +
                             " parameters, expected 9: fx, fy, cx, cy, k1, k2, k3, p1, p2");
  if (!artifact.beyond.empty())
    throw std::runtime_error("camera '" + artifact.id + "' (" + artifact.source + ") has " + artifact.beyond +
                             " beside its nine parameters, which alone would project wrongly; use a camera adjusted "
                             "without, or the figures of the block that made it");
  BrownCamera camera;
  camera.width = artifact.width;
  camera.height = artifact.height;
  std::array<double, BrownCamera::parameter_count> values;
  std::copy(artifact.parameters.begin(), artifact.parameters.end(), values.begin());
  camera.set_parameters(values);
  if (!(camera.fx > 0 && camera.fy > 0))
    throw std::runtime_error("camera '" + artifact.id + "' has no positive principal distance (fx, fy)");
  return camera;
}

}  // namespace plumbline

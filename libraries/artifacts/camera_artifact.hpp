// From the artifact of schemas/artifacts/camera.fbs to geometry/camera.hpp. For plugins: it needs the generated code.
#pragma once

#include <algorithm>
#include <array>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "artifacts/camera.hpp"
#include "geometry/camera.hpp"
#include "geometry/packed_symmetric.hpp"

namespace plumbline {

/// The parameters of its lens, whatever the camera has beside them.
inline InteriorOrientation parameters_of(const CameraT& artifact) {
  InteriorOrientation camera;
  const auto lens = artifact.lens.empty() ? LensModel::brown : lens_called(artifact.lens);
  if (!lens)
    throw std::runtime_error("camera '" + artifact.id + "' has the lens '" + artifact.lens +
                             "'; known are brown and fisheye");
  camera.lens = *lens;
  if (artifact.parameters.size() != camera.names().size()) {
    std::string names;
    for (const char* name : camera.names()) names += (names.empty() ? "" : ", ") + std::string(name);
    throw std::runtime_error("camera '" + artifact.id + "' has " + std::to_string(artifact.parameters.size()) +
                             " parameters, expected " + std::to_string(camera.names().size()) + ": " + names);
  }
  camera.width = artifact.width;
  camera.height = artifact.height;
  std::array<double, InteriorOrientation::parameter_count> values{};
  std::copy(artifact.parameters.begin(), artifact.parameters.end(), values.begin());
  camera.set_parameters(values);
  if (!(camera.fx > 0 && camera.fy > 0))
    throw std::runtime_error("camera '" + artifact.id + "' has no positive principal distance (fx, fy)");
  return camera;
}

[[noreturn]] inline void refuse_as_incomplete(const CameraT& artifact) {
  throw std::runtime_error("camera '" + artifact.id + "' (" + artifact.source + ") has " + artifact.beyond +
                           " beside its parameters, which alone would project wrongly; use a camera adjusted "
                           "without, or the figures of the block that made it");
}

/// Its covariance, 9 × 9 as InteriorOrientation has its parameters; empty if they are taken as exact.
inline Eigen::MatrixXd interior_covariance_of(const CameraT& artifact) {
  return unpack_symmetric(artifact.covariance, InteriorOrientation::parameter_count, "camera '" + artifact.id + "'");
}

/// Size, lens, parameters and, unless it is empty, the 9 × 9 covariance.
inline void set_interior(const InteriorOrientation& interior, const Eigen::MatrixXd& covariance, CameraT& artifact) {
  artifact.width = interior.width, artifact.height = interior.height;
  artifact.lens = interior.lens == LensModel::brown ? "" : name_of(interior.lens);
  const auto values = interior.parameters();
  artifact.parameters.assign(values.begin(), values.begin() + std::ssize(interior.names()));
  if (covariance.size() > 0) artifact.covariance = pack_symmetric(covariance);
}

/// Who projects with one camera would take the photographs of all others for its own.
inline void require_alone(const CameraT& artifact) {
  if (artifact.others.empty()) return;
  std::string names = "'" + artifact.id + "'";
  for (const auto& other : artifact.others) names += ", '" + other->id + "'";
  throw std::runtime_error("the photographs are of " + std::to_string(artifact.others.size() + 1) + " cameras (" +
                           names +
                           "), and one is expected here; adjust.schur, adjust.ceres and adjust.colmap take "
                           "several");
}

/// The camera and its `others`, each by itself. Throws std::runtime_error if two have one name.
inline std::vector<CameraT> cameras_of(CameraT artifact) {
  std::vector<CameraT> cameras;
  const auto others = std::move(artifact.others);
  artifact.others.clear();
  cameras.push_back(std::move(artifact));
  for (const auto& other : others) {
    for (const CameraT& camera : cameras)
      if (camera.id == other->id) throw std::runtime_error("two cameras are called '" + other->id + "'");
    cameras.push_back(*other);
  }
  return cameras;
}

/// The way back: the first with all others. `cameras` is not empty.
inline CameraT joined_cameras(const std::vector<CameraT>& cameras) {
  CameraT artifact = cameras.front();
  for (size_t c = 1; c < cameras.size(); ++c) artifact.others.push_back(std::make_unique<CameraT>(cameras[c]));
  return artifact;
}

/// Throws std::runtime_error, naming the camera, unless its parameters say all of it, and positive
/// principal distances.
inline InteriorOrientation camera_of(const CameraT& artifact) {
  require_alone(artifact);
  const InteriorOrientation camera = parameters_of(artifact);
  if (!artifact.beyond.empty() || !artifact.distance_terms.empty() || artifact.image_principal_points)
    refuse_as_incomplete(artifact);
  return camera;
}

/// A camera with what an adjustment may have found beside the parameters of its lens. Source of the distance terms:
/// Magill (1955), Brown (1971), see block/bundle/lens.hpp.
struct CompleteCamera {
  InteriorOrientation nine;
  Eigen::Vector2d distance_terms = Eigen::Vector2d::Zero();  ///< d1, d2 [m]
  double reference_distance = 0;                             ///< Z0 [m]; 0: no distance terms
  bool image_principal_points = false;                       ///< they stand with the poses

  /// Its parameters for what lies `depth` [m] before the camera.
  InteriorOrientation at(double depth) const {
    InteriorOrientation camera = nine;
    if (!(reference_distance > 0)) return camera;
    const double s = 1 / depth - 1 / reference_distance;
    camera.k1 += distance_terms.x() * s;
    camera.k2 += distance_terms.y() * s;
    return camera;
  }
};

/// Throws as camera_of(), but only refuses what the artifact has words for and no numbers: one of an older version.
inline CompleteCamera complete_camera_of(const CameraT& artifact) {
  require_alone(artifact);
  CompleteCamera camera;
  camera.nine = parameters_of(artifact);
  if (!artifact.beyond.empty() && artifact.distance_terms.empty() && !artifact.image_principal_points)
    refuse_as_incomplete(artifact);
  camera.image_principal_points = artifact.image_principal_points;
  if (artifact.distance_terms.empty()) return camera;
  if (artifact.distance_terms.size() != 2 || !(artifact.reference_distance > 0))
    throw std::runtime_error("camera '" + artifact.id + "' has " + std::to_string(artifact.distance_terms.size()) +
                             " distance terms, expected d1 and d2 and a positive reference distance");
  camera.distance_terms = {artifact.distance_terms[0], artifact.distance_terms[1]};
  camera.reference_distance = artifact.reference_distance;
  return camera;
}

/// What is added to the camera's principal point in the image of `pose` [px]. Throws std::runtime_error, naming the
/// image, if the camera says that images have principal points of their own and this one has none.
template <typename Pose>
Eigen::Vector2d principal_point_of(const CompleteCamera& camera, const Pose& pose) {
  if (!camera.image_principal_points) return Eigen::Vector2d::Zero();
  if (pose.principal_point.size() != 2)
    throw std::runtime_error("images have principal points of their own, as the camera says, but the pose of " +
                             pose.path + " has none; take camera and poses of one adjustment");
  return {pose.principal_point[0], pose.principal_point[1]};
}

}  // namespace plumbline

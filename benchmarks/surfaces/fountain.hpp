// Photographs and published cameras of fountain-P11 or Herz-Jesus-P8 (Strecha et al. 2008).
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "surface/dense/facet.hpp"

namespace plumbline::surface {

/// K, three zeros, the rotation whose columns are the camera's axes in the world, the projection centre, the size.
inline View read_camera(const std::string& path) {
  std::ifstream stream(path);
  std::array<double, 26> v{};
  for (double& value : v)
    if (!(stream >> value)) throw std::runtime_error(path + " is no camera of the set");
  View view;
  view.camera.fx = v[0], view.camera.fy = v[4], view.camera.cx = v[2], view.camera.cy = v[5];
  view.camera.width = static_cast<int>(v[24]), view.camera.height = static_cast<int>(v[25]);
  Eigen::Matrix3d world_from_cam;
  world_from_cam << v[12], v[13], v[14], v[15], v[16], v[17], v[18], v[19], v[20];
  view.cam_from_world.rotation = Eigen::Quaterniond(world_from_cam.transpose()).normalized();
  view.cam_from_world.translation = -(view.cam_from_world.rotation * Eigen::Vector3d(v[21], v[22], v[23]));
  return view;
}

struct Fountain {
  std::vector<View> views;
  std::vector<Pyramid> images;
  std::vector<FacetView> every(size_t first, size_t step) const {
    std::vector<FacetView> chosen;
    for (size_t k = first; k < views.size(); k += step) chosen.push_back({&views[k], &images[k]});
    return chosen;
  }
  /// The plane `distance` [m] before the middle camera and `above` [m] it, turned about the vertical by `turn` [°].
  FacadePlane wall(double distance, double above = 0, double turn = 0) const {
    const RigidTransform world_from_cam = views[views.size() / 2].cam_from_world.inverse();
    Eigen::Vector3d forward = world_from_cam.rotation * Eigen::Vector3d::UnitZ();
    forward.z() = 0;
    const Eigen::Vector3d origin = world_from_cam.translation + distance * forward.normalized();
    const Eigen::AngleAxisd turned(turn * M_PI / 180, Eigen::Vector3d::UnitZ());
    return facade_plane(origin + above * Eigen::Vector3d::UnitZ(), turned * -forward);
  }
};

inline Fountain read_fountain(const std::string& folder) {
  Fountain photographs;
  for (int k = 0; k < 100; ++k) {
    char name[16];
    std::snprintf(name, sizeof name, "%04d.jpg", k);
    if (!std::filesystem::exists(folder + "/gt_dense_cameras/" + name + ".camera")) break;
    photographs.views.push_back(read_camera(folder + "/gt_dense_cameras/" + name + ".camera"));
    photographs.images.push_back(pyramid_of(read_grey_image(folder + "/images/" + name)));
  }
  if (photographs.views.size() < 6)
    throw std::runtime_error(folder + " has not both images/ and gt_dense_cameras/ of a set");
  return photographs;
}

}  // namespace plumbline::surface

// COLMAP models, text and binary. Pixels are kept as this project has them: the centre of the top-left pixel is (0, 0);
// COLMAP's files have it at (0.5, 0.5), and reading and writing shift by that.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "geometry/camera.hpp"
#include "plumbline/rigid_transform.hpp"

namespace plumbline::cameras {

struct ColmapCamera {
  std::uint32_t id = 0;
  std::string model;  ///< of the file: SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL, OPENCV or FULL_OPENCV
  BrownCamera camera;
};

struct ColmapFeature {
  Eigen::Vector2d pixel;
  std::int64_t point = -1;  ///< id of its point; −1: none
};

struct ColmapImage {
  std::uint32_t id = 0, camera = 0;
  std::string name;
  RigidTransform cam_from_world;
  std::vector<ColmapFeature> features;
};

struct ColmapPoint {
  Eigen::Vector3d position;
  std::array<std::uint8_t, 3> colour{};
  double error = -1;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> track;  ///< image id, index of the feature
};

struct ColmapModel {
  std::map<std::uint32_t, ColmapCamera> cameras;
  std::map<std::uint32_t, ColmapImage> images;
  std::map<std::int64_t, ColmapPoint> points;
};

/// Reads cameras, images and points3D (.bin if it is there, else .txt) of a folder. Throws std::runtime_error that
/// names file, line or byte, what was found and what to do: a camera model that is not Brown's, a track to an image
/// that is not there, a file that ends early.
ColmapModel read_colmap(const std::string& folder);

/// Text files of a model, by name: cameras.txt, images.txt, points3D.txt. Cameras are written as OPENCV, or FULL_OPENCV
/// where k3 is not zero.
std::map<std::string, std::string> colmap_text(const ColmapModel& model);

}  // namespace plumbline::cameras

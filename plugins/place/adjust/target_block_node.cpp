#include "target_block_node.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <set>
#include <stdexcept>

#include "artifacts/camera_artifact.hpp"
#include "control/points/image_points.hpp"
#include "photo/cameras/camera_groups.hpp"
#include "target_block_artifacts.hpp"

namespace plumbline::block {
namespace {

constexpr double unknown_pitch = 1e-3;  // [mm]

struct Camera {
  std::string id;
  BrownCamera brown;
  double pitch;  // [mm]
};

/// A camera without distortion in the sensor plane; the measurements are freed of it.
SensorCamera ideal_camera(const Camera& camera, int id) {
  SensorCamera ideal;
  ideal.id = id;
  ideal.lens = bundle::Lens::correcting;
  ideal.width = camera.brown.width, ideal.height = camera.brown.height;
  ideal.sensor_width = camera.pitch * camera.brown.width, ideal.sensor_height = camera.pitch * camera.brown.height;
  ideal.values = {camera.pitch * camera.brown.fx, camera.pitch * (camera.brown.cx + 0.5),
                  camera.pitch * (camera.brown.cy + 0.5)};
  return ideal;
}

size_t camera_of_image(const std::vector<Camera>& cameras, const std::string& path) {
  for (size_t c = 0; c < cameras.size(); ++c)
    if (cameras.size() == 1 || cameras[c].id == cameras::folder_of(path)) return c;
  throw std::runtime_error(path + " is of none of the " + std::to_string(cameras.size()) +
                           " cameras: give one camera, or several that are called as the images' folders");
}

BlockImage image_of(const PoseT& pose, int id, size_t camera) {
  // Camera frame of Poses: y down, z forward; the sensor's: y up, the scene at negative z.
  const Eigen::Quaterniond half_turn(0, 1, 0, 0);
  const Eigen::Quaterniond rotation = half_turn * pose.cam_from_world.rotation;
  return {id, static_cast<int>(camera), pose.cam_from_world.inverse().translation,
          angles_from_rotation(rotation.toRotationMatrix().transpose())};
}

void add_control(const PointsT& given, PointBlock& block) {
  std::vector<Eigen::Vector3d> positions, variances;
  for (size_t j = 0; j < given.points.size(); ++j) {
    const PointT& p = *given.points[j];
    if (p.role.empty() || !p.sigma.allFinite()) continue;
    block.control.points.push_back(static_cast<int>(j));
    block.control.is_check.push_back(p.role == "check");
    positions.push_back(p.position), variances.push_back(p.sigma.cwiseAbs2());
  }
  const Eigen::Index size = 3 * static_cast<Eigen::Index>(positions.size());
  block.control.position.resize(size), block.control.covariance = Eigen::MatrixXd::Zero(size, size);
  for (size_t k = 0; k < positions.size(); ++k) {
    const Eigen::Index at = 3 * static_cast<Eigen::Index>(k);
    block.control.position.segment<3>(at) = positions[k];
    block.control.covariance.diagonal().segment<3>(at) = variances[k];
  }
}

}  // namespace

void BlockOfTargets::run(Context& context) {
  std::vector<Camera> known;
  ReadBlock read;
  for (size_t c = 0; c < cameras.size(); ++c) {
    const CameraT given = cameras.unpack(c);
    if (camera_of(given).lens != LensModel::brown)
      throw std::runtime_error("camera '" + given.id +
                               "' is a fisheye, which a block of targets cannot take: its coordinates are those of a "
                               "pinhole, as PhotoModeler has them. Use tags (adjust.schur), which take fisheyes");
    known.push_back({given.id, camera_of(given), given.pixel_pitch > 0 ? 1e3 * given.pixel_pitch : unknown_pitch});
    read.block.cameras.push_back(ideal_camera(known.back(), static_cast<int>(c) + 1));
  }
  std::map<std::string, int> image_index, point_index;
  const PosesT oriented = poses.unpack();
  std::map<std::string, const PoseT*> by_path;
  for (const auto& pose : oriented.poses) by_path[pose->path] = pose.get();
  for (const auto& [path, pose] : by_path) {
    const int index = static_cast<int>(image_index.size());
    image_index[path] = index;
    read.block.images.push_back(image_of(*pose, index + 1, camera_of_image(known, path)));
  }
  const PointsT given = points.unpack();
  for (const auto& p : given.points) {
    if (!p->position.allFinite())
      throw std::runtime_error("point " + p->id + " has a coordinate that is not known; give approximate ones");
    point_index.emplace(p->id, static_cast<int>(read.block.points.size()));
    read.block.points.push_back({p->id, p->position});
  }
  const FileT file = table.unpack();
  std::set<std::string> unknown_images, unknown_points;
  for (const auto& m : control::parse_image_points({file.content.begin(), file.content.end()}, file.name, false)) {
    ++read.measurements_read;
    const auto image = image_index.find(m.image), point = point_index.find(m.point);
    if (image == image_index.end()) unknown_images.insert(m.image);
    if (point == point_index.end()) unknown_points.insert(m.point);
    if (image == image_index.end() || point == point_index.end()) continue;
    const Camera& camera = known[read.block.images[image->second].camera];
    const auto ray = unproject(camera.brown, m.pixel);
    if (!ray)
      throw std::runtime_error(file.name + ": " + m.point + " in " + m.image +
                               " lies where the camera's distortion has no inverse: the calibration is not of this "
                               "photograph, or does not reach there");
    // One principal distance for both axes: what was freed of the distortion is freed of fy / fx, too.
    const Eigen::Vector2d ideal = camera.brown.fx * *ray + Eigen::Vector2d(camera.brown.cx, camera.brown.cy);
    read.block.measurements.push_back({image->second, point->second, camera.pitch * (ideal + Eigen::Vector2d(0.5, 0.5)),
                                       camera.pitch * (m.sigma > 0 ? m.sigma : *sigma)});
  }
  for (const auto& name : unknown_images) read.left_out.push_back("photograph " + name + ": it has no pose");
  for (const auto& name : unknown_points) read.left_out.push_back("target " + name + ": it is no point");
  add_control(given, read.block);
  drop_unusable(read);
  for (const auto& what : read.left_out) context.warn("left out: " + what);
  if (read.block.measurements.empty())
    throw std::runtime_error(file.name + ": none of its " + std::to_string(read.measurements_read) +
                             " measurements can be used; photographs and points are called otherwise than poses and "
                             "points, or too few belong together");
  block.commit(target_block_artifact(read));
}

}  // namespace plumbline::block

// A facade with marker plates and cameras before it, as artifacts, without noise unless asked: what conformance kits
// are fed with.
//
// Frame: x along the facade, y into it, z up; plates face -y. Floors of 4 m with two rows at +0.5 m and +2.5 m, columns
// 2 m apart.
#pragma once

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "artifacts/camera.hpp"
#include "artifacts/image_tags.hpp"
#include "artifacts/plates.hpp"
#include "artifacts/points.hpp"
#include "artifacts/poses.hpp"
#include "geometry/camera.hpp"
#include "geometry/marker_plate.hpp"
#include "plumbline/rigid_transform.hpp"

namespace plumbline::test {

/// splitmix64 and the Box-Muller transform: the same numbers with every standard library.
class Random {
 public:
  explicit Random(uint64_t seed) : state_(seed) {}
  double uniform() {  ///< in (0, 1)
    uint64_t z = (state_ += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return (static_cast<double>((z ^ (z >> 31)) >> 11) + 0.5) / 9007199254740992.0;
  }
  double normal() { return std::sqrt(-2 * std::log(uniform())) * std::cos(2 * M_PI * uniform()); }
  Eigen::Vector3d normal3(double sigma) {
    const double x = normal(), y = normal(), z = normal();
    return sigma * Eigen::Vector3d(x, y, z);
  }

 private:
  uint64_t state_;
};

struct FacadeOptions {
  int floors = 1, columns = 4;
  double pixel_sigma = 0;   ///< noise of a corner, per coordinate [px]
  double survey_sigma = 0;  ///< noise of a control coordinate [m]
  uint64_t seed = 1;
  RigidTransform world_from_facade = {};  ///< everything is expressed in `world`
};

struct SyntheticFacade {
  BrownCamera camera;
  PlatesT plates;
  PointsT truth;    ///< true anchors
  PointsT control;  ///< the same with survey noise, and its covariance if there is noise
  PosesT poses;     ///< true poses
  std::vector<ImageTagsT> images;

  CameraT camera_artifact() const {
    CameraT artifact;
    artifact.id = "camera";
    artifact.width = camera.width;
    artifact.height = camera.height;
    const auto values = camera.parameters();
    artifact.parameters.assign(values.begin(), values.end());
    return artifact;
  }
};

namespace detail {

inline void add_anchor(SyntheticFacade& facade, const FacadeOptions& options, Random& random, int floor, int column,
                       int row) {
  // A facade is not quite flat: 2 cm out of plane, and plates sit a degree or two off.
  const Eigen::Vector3d anchor(2.0 * (column - 1), 0.02 * random.normal(), 4.0 * (floor - 1) + (row == 1 ? 0.5 : 2.5));
  Eigen::Matrix3d facing;
  facing << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  auto plate = std::make_unique<PlateT>();
  plate->anchor = "F0" + std::to_string(floor) + "-C0" + std::to_string(column) + "-R" + std::to_string(row);
  plate->tag_family = "tag36h11";
  plate->tag_id = static_cast<int>(facade.plates.plates.size());
  plate->tag_size = 0.2;
  plate->tag_centre_in_plate = Eigen::Vector3d(0, -0.16, 0);
  plate->nominal_rotation = options.world_from_facade.rotation * Eigen::Quaterniond(facing);
  plate->role = "control";
  plate->batch = "batch";
  plate->floor = floor;
  plate->column = column;
  plate->row = row;
  auto point = std::make_unique<PointT>();
  point->id = plate->anchor;
  point->position = options.world_from_facade * anchor;
  point->sigma.setConstant(std::nan(""));
  point->role = "control";
  auto surveyed = std::make_unique<PointT>(*point);
  surveyed->position += random.normal3(options.survey_sigma);
  if (options.survey_sigma > 0) surveyed->sigma.setConstant(options.survey_sigma);
  facade.plates.plates.push_back(std::move(plate));
  facade.truth.points.push_back(std::move(point));
  facade.control.points.push_back(std::move(surveyed));
}

/// A camera at `centre` that looks at `target`, rolled about its axis.
inline RigidTransform look_at(const Eigen::Vector3d& centre, const Eigen::Vector3d& target, double roll) {
  const Eigen::Vector3d z = (target - centre).normalized();
  const Eigen::Vector3d x = z.cross(Eigen::Vector3d::UnitZ()).normalized();
  Eigen::Matrix3d cam_from_facade;
  cam_from_facade << x.transpose(), z.cross(x).transpose(), z.transpose();
  const Eigen::Matrix3d rolled = Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitZ()).toRotationMatrix() * cam_from_facade;
  return {Eigen::Quaterniond(rolled), -(rolled * centre)};
}

inline void add_image(SyntheticFacade& facade, const FacadeOptions& options, Random& random,
                      const RigidTransform& cam_from_facade) {
  const RigidTransform cam_from_world = cam_from_facade * options.world_from_facade.inverse();
  ImageTagsT image;
  image.path = "image" + std::to_string(100 + facade.images.size()) + ".jpg";
  image.camera = "camera";
  image.width = facade.camera.width;
  image.height = facade.camera.height;
  for (size_t i = 0; i < facade.plates.plates.size(); ++i) {
    const PlateT& plate = *facade.plates.plates[i];
    // The true plate is turned by up to two degrees against its nominal rotation, the same in every image.
    Random turn(1000 + i);
    const RigidTransform world_from_plate{plate.nominal_rotation * quaternion_from_rotation_vector(turn.normal3(0.02)),
                                          facade.truth.points[i]->position};
    auto tag = std::make_unique<TagT>();
    tag->family = plate.tag_family;
    tag->id = plate.tag_id;
    for (const Eigen::Vector3d& corner : tag_corners_in_plate({plate.tag_size, plate.tag_centre_in_plate})) {
      const auto pixel = project(facade.camera, cam_from_world * (world_from_plate * corner));
      if (!pixel || pixel->x() < 0 || pixel->y() < 0 || pixel->x() > facade.camera.width - 1 ||
          pixel->y() > facade.camera.height - 1)
        break;
      const double dx = random.normal(), dy = random.normal();
      tag->corners.push_back(*pixel + options.pixel_sigma * Eigen::Vector2d(dx, dy));
    }
    const double variance = options.pixel_sigma > 0 ? options.pixel_sigma * options.pixel_sigma : 0.01;
    for (int k = 0; k < 4; ++k) tag->corner_covariances.insert(tag->corner_covariances.end(), {variance, 0, variance});
    if (tag->corners.size() == 4) image.tags.push_back(std::move(tag));
  }
  auto pose = std::make_unique<PoseT>();
  pose->path = image.path;
  pose->cam_from_world = cam_from_world;
  facade.poses.poses.push_back(std::move(pose));
  facade.images.push_back(std::move(image));
}

}  // namespace detail

/// Eight images a floor: four stations at 8 m, convergent, each once upright and once rolled by 90 degrees.
inline SyntheticFacade make_facade(const FacadeOptions& options) {
  SyntheticFacade facade;
  facade.camera.width = 11656;
  facade.camera.height = 8742;
  facade.camera.fx = facade.camera.fy = 0.038 / 3.76e-6;
  facade.camera.cx = 5830.2;
  facade.camera.cy = 4365.7;
  facade.camera.k1 = -0.03;
  facade.camera.k2 = 0.01;
  facade.camera.p1 = 1e-4;
  Random random(options.seed);
  for (int floor = 1; floor <= options.floors; ++floor)
    for (int row = 1; row <= 2; ++row)
      for (int column = 1; column <= options.columns; ++column)
        detail::add_anchor(facade, options, random, floor, column, row);
  if (options.survey_sigma > 0)
    for (size_t i = 0; i < 3 * facade.control.points.size(); ++i)
      for (size_t j = 0; j <= i; ++j)
        facade.control.covariance.push_back(i == j ? options.survey_sigma * options.survey_sigma : 0.0);
  const double middle = options.columns - 1.0;
  for (int floor = 1; floor <= options.floors; ++floor)
    for (int station = 0; station < 4; ++station)
      for (int roll = 0; roll < 2; ++roll) {
        const double height = 4.0 * (floor - 1) + 1.5;
        const Eigen::Vector3d centre(middle - 4.5 + 3.0 * station, -8, height + (station % 2 ? 1.0 : -1.0));
        detail::add_image(facade, options, random,
                          detail::look_at(centre, {middle, 0, height + (roll ? 0.5 : 0.0)}, roll * M_PI / 2));
      }
  return facade;
}

}  // namespace plumbline::test

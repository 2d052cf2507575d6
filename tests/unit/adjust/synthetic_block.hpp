// A facade with marker plates and photographs of it, without pixels: the geometry of the bound's table in the
// documentation.
//
// World: x along the facade, y into it, z up. 4 columns × 2 rows of control plates a floor on 2.0 m spacing, storey
// height 3.0 m, rows 0.5 and 2.5 m above the floor, 2 cm of scatter out of the plane, and 3 check plates a floor at the
// cell centres. Camera of 11656 × 8742 px of 3.76 µm, f = 38 mm, 8 m in front; 16 images a floor, convergent, tilted up
// and down, 0 and 90 degrees of roll.
#pragma once

#include <Eigen/Cholesky>
#include <cmath>
#include <cstdint>

#include "photo/block/tag_block.hpp"

namespace plumbline::test {

/// splitmix64 and Box-Muller: the same numbers with every standard library.
class Random {
 public:
  explicit Random(uint64_t seed) : state_(seed) {}
  double uniform() { return (static_cast<double>(next() >> 11) + 0.5) * 0x1p-53; }
  double normal() { return std::sqrt(-2 * std::log(uniform())) * std::cos(2 * M_PI * uniform()); }

 private:
  uint64_t next() {
    uint64_t z = (state_ += 0x9e3779b97f4a7c15ULL);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
    return z ^ (z >> 31);
  }
  uint64_t state_;
};

struct SyntheticOptions {
  int floors = 2;
  int stations = 4;             ///< on each floor, with 4 images each
  double corner_sigma = 0.2;    ///< of one corner [px]: 0.1 px for the centre of a marker
  double survey_sigma = 0.001;  ///< [m]
  double scatter = 0.02;        ///< out of the facade's plane [m]
  bool noise = true;
  uint64_t seed = 1;
  bool two_cameras = false;  ///< every second image is another camera's
  bool fisheye = false;      ///< of about 85 degrees to the corners of the image, in place of the 38 mm
};

struct SyntheticBlock {
  block::TagBlock block;
  std::vector<Eigen::Vector3d> anchors;        ///< truth, in the order of block.plates
  std::vector<RigidTransform> cam_from_world;  ///< truth
  std::vector<Eigen::Quaterniond> world_from_plate;
  BrownCamera camera;      ///< truth
  BrownCamera second;      ///< truth, with two_cameras
  std::vector<int> check;  ///< plates that are never control
  Eigen::VectorXd survey;  ///< 3n, of all plates
  double survey_sigma = 0;

  const BrownCamera& camera_of(int image) const { return block.images[image].camera == 1 ? second : camera; }
  /// Makes these plates the control.
  void use_control(const std::vector<int>& plates) {
    const Eigen::Index count = 3 * static_cast<Eigen::Index>(plates.size());
    block.control.plates = plates;
    block.control.position.resize(count);
    for (size_t k = 0; k < plates.size(); ++k)
      block.control.position.segment<3>(3 * k) = survey.segment<3>(3 * plates[k]);
    block.control.covariance = survey_sigma * survey_sigma * Eigen::MatrixXd::Identity(count, count);
  }
  /// Control plates whose name fulfils a condition on floor, column, row (from 1).
  template <typename Condition>
  std::vector<int> choose(Condition condition) const {
    std::vector<int> chosen;
    for (size_t j = 0; j < block.plates.size(); ++j) {
      int floor = 0, column = 0, row = 0;
      if (std::sscanf(block.plates[j].anchor.c_str(), "F%d-C%d-R%d", &floor, &column, &row) == 3 &&
          condition(floor, column, row))
        chosen.push_back(static_cast<int>(j));
    }
    return chosen;
  }
};

inline RigidTransform look_at(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double roll) {
  const Eigen::Vector3d forward = (to - from).normalized();
  const Eigen::Vector3d right = forward.cross(Eigen::Vector3d::UnitZ()).normalized();
  Eigen::Matrix3d cam_from_world;
  cam_from_world << right.transpose(), forward.cross(right).transpose(), forward.transpose();
  const Eigen::Quaterniond rotation(Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitZ()) *
                                    Eigen::Quaterniond(cam_from_world));
  return {rotation, -(rotation * from)};
}

inline void add_plates(const SyntheticOptions& options, Random& random, SyntheticBlock& synthetic) {
  const auto add = [&](const std::string& name, double x, double z) {
    block::TagPlate plate;
    plate.anchor = name;
    plate.plate = {0.2, {0.0, 0.18, 0.0}};
    Eigen::Matrix3d facing;
    facing << 1, 0, 0, 0, 0, -1, 0, 1, 0;  // plate x, y, z in the world: along the facade, up, towards the cameras
    plate.nominal_rotation = Eigen::Quaterniond(facing);
    plate.batch = "a";
    const Eigen::Vector3d tilt(0.02 * random.normal(), 0.02 * random.normal(), 0.02 * random.normal());
    synthetic.world_from_plate.push_back(quaternion_from_rotation_vector(tilt) * plate.nominal_rotation);
    synthetic.anchors.emplace_back(x, options.scatter * random.normal(), z);
    synthetic.block.plates.push_back(plate);
  };
  char name[32];
  for (int floor = 1; floor <= options.floors; ++floor) {
    for (int column = 1; column <= 4; ++column)
      for (int row = 1; row <= 2; ++row) {
        std::snprintf(name, sizeof name, "F%02d-C%02d-R%d", floor, column, row);
        add(name, 2.0 * (column - 1), 3.0 * (floor - 1) + (row == 1 ? 0.5 : 2.5));
      }
    for (int cell = 1; cell <= 3; ++cell) {
      std::snprintf(name, sizeof name, "F%02d-check-%d", floor, cell);
      synthetic.check.push_back(static_cast<int>(synthetic.block.plates.size()));
      add(name, 2.0 * cell - 1, 3.0 * (floor - 1) + 1.5);
    }
  }
}

inline void add_images(const SyntheticOptions& options, Random& random, SyntheticBlock& synthetic) {
  char name[32];
  for (int floor = 1; floor <= options.floors; ++floor)
    for (int station = 0; station < options.stations; ++station)
      for (int tilt : {-1, 1})
        for (int roll : {0, 1}) {
          const double height = 3.0 * (floor - 1) + 1.5;
          const Eigen::Vector3d from(-1 + 8.0 / (options.stations - 1) * station, -8, height);
          const auto pose = look_at(from, {3.0 + 0.25 * (from.x() - 3.0), 0, height + 1.4 * tilt}, roll * M_PI / 2);
          std::snprintf(name, sizeof name, "image_%03zu.jpg", synthetic.cam_from_world.size() + 1);
          synthetic.cam_from_world.push_back(pose);
          // Approximate poses as a single-image resection gives them.
          const Eigen::Vector3d turn(1e-3 * random.normal(), 1e-3 * random.normal(), 1e-3 * random.normal());
          const Eigen::Vector3d shift(0.01 * random.normal(), 0.01 * random.normal(), 0.01 * random.normal());
          block::TagImage image;
          image.name = name;
          image.camera = options.two_cameras ? static_cast<int>(synthetic.cam_from_world.size() + 1) % 2 : 0;
          image.cam_from_world =
              RigidTransform{quaternion_from_rotation_vector(turn) * pose.rotation, pose.translation + shift};
          synthetic.block.images.push_back(image);
        }
}

inline void add_observations(const SyntheticOptions& options, Random& random, SyntheticBlock& synthetic) {
  for (size_t i = 0; i < synthetic.cam_from_world.size(); ++i)
    for (size_t j = 0; j < synthetic.anchors.size(); ++j) {
      block::TagObservation seen;
      seen.image = static_cast<int>(i);
      seen.plate = static_cast<int>(j);
      bool inside = true;
      const BrownCamera& camera = synthetic.camera_of(seen.image);
      const auto corners = tag_corners_in_plate(synthetic.block.plates[j].plate);
      for (size_t k = 0; k < 4; ++k) {
        const auto pixel = project(
            camera, synthetic.cam_from_world[i] * (synthetic.anchors[j] + synthetic.world_from_plate[j] * corners[k]));
        inside = inside && pixel && pixel->x() > 0 && pixel->y() > 0 && pixel->x() < camera.width &&
                 pixel->y() < camera.height;
        if (!inside) break;
        const double noise = options.noise ? options.corner_sigma : 0;
        seen.corners[k] = *pixel + Eigen::Vector2d(noise * random.normal(), noise * random.normal());
        seen.covariances[k] = options.corner_sigma * options.corner_sigma * Eigen::Matrix2d::Identity();
      }
      if (inside) synthetic.block.observations.push_back(seen);
    }
}

/// A tag as a detector has it that draws every edge inwards [px]: neighbouring edges, moved along their normals, meet.
inline std::array<Eigen::Vector2d, 4> drawn_inwards(const std::array<Eigen::Vector2d, 4>& sharp, double inset) {
  const auto normal = [](const Eigen::Vector2d& edge, const Eigen::Vector2d& inside) -> Eigen::Vector2d {
    const Eigen::Vector2d n(-edge.y(), edge.x());
    return n.dot(inside) > 0 ? n : Eigen::Vector2d(-n);
  };
  auto drawn = sharp;
  for (size_t k = 0; k < 4; ++k) {
    const Eigen::Vector2d next = (sharp[(k + 1) % 4] - sharp[k]).normalized(),
                          back = (sharp[(k + 3) % 4] - sharp[k]).normalized();
    Eigen::Matrix2d lines;
    lines << normal(next, back).transpose(), normal(back, next).transpose();
    drawn[k] += lines.inverse() * Eigen::Vector2d(inset, inset);
  }
  return drawn;
}

inline SyntheticBlock make_block(const SyntheticOptions& options) {
  Random random(options.seed);
  SyntheticBlock synthetic;
  synthetic.camera = {11656, 8742, 38e-3 / 3.76e-6, 38e-3 / 3.76e-6, 5827.5 + 12, 4370.5 - 9, -0.03, 0.01, 0,
                      2e-4,  -1e-4};
  if (options.fisheye) {
    synthetic.camera = {11656, 8742, 4900, 4900, 5827.5 + 12, 4370.5 - 9, 0.03, -0.012, 0.004, 0, 0};
    synthetic.camera.lens = LensModel::fisheye, synthetic.camera.k4 = -0.0015;
  }
  synthetic.block.cameras.resize(options.two_cameras ? 2 : 1);
  synthetic.block.cameras[0].interior = synthetic.camera;
  // What a calibration some months ago would say.
  synthetic.block.cameras[0].interior.fx += 2, synthetic.block.cameras[0].interior.fy += 2,
      synthetic.block.cameras[0].interior.cx -= 2, synthetic.block.cameras[0].interior.k1 += 3e-4;
  if (options.two_cameras) {
    synthetic.second = {6000, 4000, 4200, 4210, 3010, 1985, 0.05, -0.02, 0, -3e-4, 1e-4};
    synthetic.block.cameras[0].name = "first", synthetic.block.cameras[1].name = "second";
    synthetic.block.cameras[1].interior = synthetic.second;
    synthetic.block.cameras[1].interior.fx -= 1, synthetic.block.cameras[1].interior.cy += 1;
  }
  add_plates(options, random, synthetic);
  add_images(options, random, synthetic);
  add_observations(options, random, synthetic);
  synthetic.survey_sigma = options.survey_sigma;
  synthetic.survey.resize(3 * static_cast<Eigen::Index>(synthetic.anchors.size()));
  for (size_t j = 0; j < synthetic.anchors.size(); ++j)
    for (int c = 0; c < 3; ++c)
      synthetic.survey(3 * static_cast<Eigen::Index>(j) + c) =
          synthetic.anchors[j](c) + (options.noise ? options.survey_sigma * random.normal() : 0);
  synthetic.use_control(synthetic.choose([](int, int, int) { return true; }));
  return synthetic;
}

/// Known weights, no prior on the interior orientation, tag size unknown: the setting of the bound's table.
inline block::TagBlockOptions bound_options() {
  block::TagBlockOptions options;
  options.fixed_aspect = true;
  options.tag_scale_sigma = std::numeric_limits<double>::infinity();
  options.loss = block::RobustLoss::none;
  options.estimate_image_variance = false;
  return options;
}

inline Eigen::Index row_of_plate(const block::TagBlockResult& result, int plate) {
  return 3 * (std::find(result.plates.begin(), result.plates.end(), plate) - result.plates.begin());
}

/// Predicted root mean square standard deviation of the check anchors' coordinate (0 … 2).
inline double predicted_rmse(const SyntheticBlock& synthetic, const block::TagBlockResult& result, int coordinate) {
  double sum = 0;
  for (int plate : synthetic.check) {
    const Eigen::Index i = row_of_plate(result, plate) + coordinate;
    sum += result.anchor_covariance(i, i);
  }
  return std::sqrt(sum / static_cast<double>(synthetic.check.size()));
}

inline double rmse_of_check(const SyntheticBlock& synthetic, const block::TagBlockResult& result, int coordinate) {
  double sum = 0;
  for (int plate : synthetic.check)
    sum += std::pow(result.anchors(row_of_plate(result, plate) + coordinate) - synthetic.anchors[plate](coordinate), 2);
  return std::sqrt(sum / static_cast<double>(synthetic.check.size()));
}

/// What the call throws, as text; empty if it throws nothing.
template <typename Call>
std::string error_of(Call call) {
  try {
    call();
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return {};
}

}  // namespace plumbline::test

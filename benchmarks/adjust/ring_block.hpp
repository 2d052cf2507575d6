// Synthetic blocks of the shape of well-known ones: a ring of images around a cube of points.
#pragma once

#include <cmath>
#include <cstdint>
#include <string>

#include "photo/bundle/lens.hpp"
#include "photo/bundle/problem.hpp"
#include "plumbline/rigid_transform.hpp"

namespace plumbline {

/// splitmix64 and Box-Muller: the same problem everywhere.
class Random {
 public:
  explicit Random(uint64_t seed) : state_(seed) {}
  double uniform() {
    uint64_t z = (state_ += 0x9e3779b97f4a7c15ULL);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
    return (static_cast<double>((z ^ (z >> 31)) >> 11) + 0.5) * 0x1p-53;
  }
  double normal() { return std::sqrt(-2 * std::log(uniform())) * std::cos(2 * M_PI * uniform()); }
  Eigen::Vector3d vector(double size) { return size * Eigen::Vector3d(normal(), normal(), normal()); }

 private:
  uint64_t state_;
};

struct Shape {
  int images, points, rays;
  bool anywhere = false;
};

struct Made {
  bundle::Problem problem;
  bundle::State truth, start;
};

/// Images on a ring around a cube of points, one camera, each point seen by `rays` neighbouring images; 0.5 px noise;
/// two images are held, so that the datum is given and Ceres has observations of one size only.
inline Made make(const Shape& shape) {
  using namespace bundle;
  Made made;
  Problem& p = made.problem;
  Random random(1);
  p.groups = {{"images"}};
  p.cameras.push_back(
      {"camera", Lens::brown, 0, {true, true, true, true, true, true, false, false, false, false, false}});
  made.truth.interiors.push_back({3000, 3000, 2000, 1500, -0.1, 0.05, 0, 0, 0, 0});
  for (int i = 0; i < shape.images; ++i) {
    const double angle = 2 * M_PI * i / shape.images;
    const Eigen::Vector3d centre(20 * std::cos(angle), 20 * std::sin(angle), 4 * std::sin(3 * angle));
    const Eigen::Vector3d z = (random.vector(0.5) - centre).normalized();
    const Eigen::Vector3d x = z.cross(Eigen::Vector3d::UnitZ()).normalized();
    Eigen::Matrix3d world_from_camera;
    world_from_camera << x, z.cross(x), z;
    p.images.push_back({std::to_string(i), 0});
    made.truth.images.emplace_back();
    made.truth.images.back().set(Eigen::Quaterniond(Eigen::Matrix3d(world_from_camera.transpose())), centre);
  }
  for (int j = 0; j < shape.points; ++j) {
    p.points.push_back({std::to_string(j)});
    made.truth.points.emplace_back(8 * (random.uniform() - 0.5), 8 * (random.uniform() - 0.5),
                                   8 * (random.uniform() - 0.5));
    const int first = static_cast<int>(random.uniform() * shape.images);
    for (int r = 0; r < shape.rays; ++r) {
      ImagePoint o;
      o.image =
          (first + r * (shape.anywhere ? 1 + static_cast<int>(random.uniform() * shape.images / shape.rays) : 1)) %
          shape.images;
      o.point = j;
      const Placement& pose = made.truth.images[o.image];
      LensRows rows;
      if (!evaluate_lens(Lens::brown, made.truth.interiors[0].data(), 0, 0,
                         pose.matrix * (made.truth.points.back() - pose.position), Eigen::Vector2d::Zero(), false,
                         rows))
        continue;
      o.observed = rows.misclosure + 0.5 * Eigen::Vector2d(random.normal(), random.normal());
      o.whitening = 2 * Eigen::Matrix2d::Identity();
      p.image_points.push_back(o);
    }
  }
  made.start = made.truth;
  p.images[0].fixed = p.images[shape.images / 4].fixed = true;
  for (size_t i = 0; i < p.images.size(); ++i) {
    if (p.images[i].fixed) continue;
    Placement& pose = made.start.images[i];
    pose.set(quaternion_from_rotation_vector(random.vector(0.002)) * pose.rotation,
             pose.position + random.vector(0.05));
  }
  for (auto& point : made.start.points) point += random.vector(0.05);
  return made;
}

}  // namespace plumbline

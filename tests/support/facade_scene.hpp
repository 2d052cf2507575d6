// A facade with planted relief, texture and joints, and photographs of it by an own renderer that shares nothing with
// what is tested but the camera model: every pixel is the mean of rays that are intersected with the relief.
#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <random>
#include <vector>

#include "geometry/camera.hpp"
#include "photo/images/grey_image.hpp"
#include "plumbline/rigid_transform.hpp"
#include "surface/dense/facade_plane.hpp"

namespace plumbline::testing {

inline double lattice(std::int64_t x, std::int64_t y, std::uint64_t seed) {
  std::uint64_t h =
      static_cast<std::uint64_t>(x) * 0x9e3779b97f4a7c15u ^ static_cast<std::uint64_t>(y) * 0xc2b2ae3d27d4eb4fu ^ seed;
  h = (h ^ (h >> 30)) * 0xbf58476d1ce4e5b9u;
  h = (h ^ (h >> 27)) * 0x94d049bb133111ebu;
  return static_cast<double>((h ^ (h >> 31)) >> 11) * 0x1.0p-53;
}

/// Noise between 0 and 1 with features from `finest` to 16 times that [m].
inline double plaster(double u, double v, double finest, std::uint64_t seed = 7) {
  double sum = 0, size = finest;
  for (int octave = 0; octave < 4; ++octave, size *= 2) {
    const double x = u / size, y = v / size, fx = std::floor(x), fy = std::floor(y);
    double a = x - fx, b = y - fy;
    a = a * a * (3 - 2 * a), b = b * b * (3 - 2 * b);
    const auto ix = static_cast<std::int64_t>(fx), iy = static_cast<std::int64_t>(fy);
    const std::uint64_t s = seed + static_cast<std::uint64_t>(octave) * 1000;
    sum += (lattice(ix, iy, s) * (1 - a) + lattice(ix + 1, iy, s) * a) * (1 - b) +
           (lattice(ix, iy + 1, s) * (1 - a) + lattice(ix + 1, iy + 1, s) * a) * b;
  }
  return sum / 4;
}

struct FacadeScene {
  surface::FacadePlane plane;
  std::function<double(double, double)> height = [](double, double) { return 0.0; };  ///< relief [m]
  std::function<double(double, double)> reflectance = [](double u, double v) { return plaster(u, v, 0.002); };
};

/// Light from 0 to 1 in every pixel, without noise.
inline std::vector<float> photograph(const FacadeScene& scene, const BrownCamera& camera,
                                     const RigidTransform& cam_from_world, int supersampling = 3) {
  std::vector<float> light(static_cast<size_t>(camera.width) * camera.height);
  const RigidTransform world_from_cam = cam_from_world.inverse();
  const Eigen::Vector3d centre = scene.plane.local(world_from_cam.translation);
  const Eigen::Matrix3d plane_from_cam = scene.plane.axes.transpose() * world_from_cam.rotation.toRotationMatrix();
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x) {
      double sum = 0;
      for (int b = 0; b < supersampling; ++b)
        for (int a = 0; a < supersampling; ++a) {
          const Eigen::Vector2d pixel(x + (a + 0.5) / supersampling - 0.5, y + (b + 0.5) / supersampling - 0.5);
          const auto ray = unproject(camera, pixel);
          const Eigen::Vector3d direction = plane_from_cam * Eigen::Vector3d(ray->x(), ray->y(), 1);
          double h = 0;
          Eigen::Vector3d at = centre;
          for (int step = 0; step < 4; ++step) {
            at = centre + direction * ((h - centre.z()) / direction.z());
            h = scene.height(at.x(), at.y());
          }
          sum += scene.reflectance(at.x(), at.y());
        }
      light[static_cast<size_t>(y) * camera.width + x] = static_cast<float>(sum / (supersampling * supersampling));
    }
  return light;
}

/// Grey values from 40 to 220 with normal noise of `sigma` grey values.
inline GreyImage exposed(const std::vector<float>& light, int width, int height, double sigma, std::uint64_t seed) {
  GreyImage image{width, height, std::vector<std::uint8_t>(light.size())};
  std::mt19937_64 random(seed);
  std::normal_distribution<double> noise(0, 1);
  for (size_t i = 0; i < light.size(); ++i)
    image.pixels[i] = static_cast<std::uint8_t>(
        std::lround(std::min(255.0, std::max(0.0, 40 + 180 * static_cast<double>(light[i]) + sigma * noise(random)))));
  return image;
}

/// A camera at `place` that looks at `target`, upright.
inline RigidTransform looking(const Eigen::Vector3d& place, const Eigen::Vector3d& target) {
  const Eigen::Vector3d forward = (target - place).normalized();
  const Eigen::Vector3d right = forward.cross(Eigen::Vector3d::UnitZ()).normalized();
  Eigen::Matrix3d world_from_cam;
  world_from_cam << right, forward.cross(right), forward;
  RigidTransform pose;
  pose.rotation = Eigen::Quaterniond(world_from_cam.transpose());
  pose.translation = -(pose.rotation * place);
  return pose;
}

}  // namespace plumbline::testing

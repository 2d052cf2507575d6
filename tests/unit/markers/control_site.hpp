// A COLMAP model of arbitrary scale and frame, with surveyed points far from the origin.
#pragma once

#include <Eigen/Geometry>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "photo/markers/control_block.hpp"

namespace plumbline::markers {

struct Site {
  cameras::ColmapModel model;
  std::vector<ControlPoint> control;
  std::vector<ImagePoint> measured;
  std::map<std::string, Eigen::Vector3d> truth;
};

/// Twelve photographs of a facade of 150 tie points, eight surveyed points at 10^6 m; noise of 0.3 px and 2 mm.
inline Site site(unsigned seed) {
  Site s;
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal(0, 1);
  std::uniform_real_distribution<double> uniform(0, 1);
  cameras::ColmapCamera camera;
  camera.id = 1, camera.model = "SIMPLE_RADIAL";
  camera.camera = {2000, 1500, 1800, 1800, 999.5, 749.5, -0.05, 0, 0, 0, 0};
  s.model.cameras[1] = camera;
  // What COLMAP has: another frame, another unit.
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, -1).normalized()));
  const Eigen::Vector3d shift(3, -2, 5), far(4.5e5, 5.4e6, 300);
  const double unit = 0.37;
  const auto to_model = [&](const Eigen::Vector3d& p) -> Eigen::Vector3d { return (turn * p) * unit + shift; };
  std::vector<RigidTransform> cameras;
  for (int k = 0; k < 12; ++k) {
    const Eigen::Vector3d centre(-6 + 2.4 * (k % 6), -12 + 0.5 * (k % 3), 2 + 5 * (k / 6)),
        target(0.5 * (k % 5 - 2), 0, 4);
    const Eigen::Vector3d z = (target - centre).normalized(), x = z.cross(Eigen::Vector3d::UnitZ()).normalized();
    Eigen::Matrix3d r;
    r << x.transpose(), z.cross(x).transpose(), z.transpose();
    const Eigen::Quaterniond q =
        Eigen::Quaterniond(Eigen::AngleAxisd(k % 2 ? 1.5 : 0, Eigen::Vector3d::UnitZ())) * Eigen::Quaterniond(r);
    cameras.push_back({q, -(q * centre)});
    cameras::ColmapImage image;
    image.id = static_cast<std::uint32_t>(k + 1), image.camera = 1, image.name = "img" + std::to_string(k) + ".jpg";
    image.cam_from_world.rotation = q * turn.conjugate();
    image.cam_from_world.translation = -(image.cam_from_world.rotation * to_model(centre));
    s.model.images[image.id] = image;
  }
  const auto see = [&](size_t k, const Eigen::Vector3d& p) -> std::optional<Eigen::Vector2d> {
    const auto pixel = project(camera.camera, cameras[k] * p);
    if (!pixel || pixel->minCoeff() < 0 || pixel->x() > 1999 || pixel->y() > 1499) return std::nullopt;
    return *pixel + 0.3 * Eigen::Vector2d(normal(random), normal(random));
  };
  for (int j = 0; j < 150; ++j) {
    const Eigen::Vector3d p(-5 + 10 * uniform(random), 0.6 * uniform(random), 8 * uniform(random));
    cameras::ColmapPoint point;
    point.position = to_model(p) + 0.002 * Eigen::Vector3d(normal(random), normal(random), normal(random));
    for (size_t k = 0; k < cameras.size(); ++k)
      if (const auto pixel = see(k, p)) {
        cameras::ColmapImage& image = s.model.images[static_cast<std::uint32_t>(k + 1)];
        point.track.emplace_back(image.id, static_cast<std::uint32_t>(image.features.size()));
        image.features.push_back({*pixel, j + 1});
      }
    s.model.points[j + 1] = point;
  }
  for (int j = 0; j < 8; ++j) {
    const Eigen::Vector3d p(-4 + 8 * (j % 4) / 3.0, 0.3 * (j % 3), 1 + 5.5 * (j / 4));
    const std::string name = "P" + std::to_string(j);
    s.truth[name] = p + far;
    s.control.push_back({name,
                         p + far + 0.002 * Eigen::Vector3d(normal(random), normal(random), normal(random)),
                         {0.002, 0.002, 0.002},
                         j == 2 || j == 5});
    for (size_t k = 0; k < cameras.size(); ++k)
      if (const auto pixel = see(k, p)) s.measured.push_back({"img" + std::to_string(k) + ".jpg", name, *pixel, 0.3});
  }
  return s;
}

}  // namespace plumbline::markers

// Tags on two walls of a corner and photographs of them, without pixels.
#pragma once

#include <Eigen/Geometry>
#include <random>

#include "geometry/similarity.hpp"
#include "photo/markers/marker_block.hpp"

namespace plumbline::markers {

inline BrownCamera true_camera() {
  BrownCamera c;
  c.width = 1600, c.height = 1200, c.fx = c.fy = 1500, c.cx = 812, c.cy = 590, c.k1 = -0.12, c.k2 = 0.05, c.p1 = 4e-4;
  return c;
}

/// A fisheye whose image reaches 85 degrees off its axis.
inline InteriorOrientation true_fisheye() {
  InteriorOrientation c = true_camera();
  c.lens = LensModel::fisheye, c.fx = c.fy = 560, c.k1 = 0.03, c.k2 = -0.012, c.k3 = 0.005, c.k4 = -0.0015, c.p1 = 0;
  return c;
}

/// A camera at `centre` that looks at `target`, turned about its own axis.
inline RigidTransform look(const Eigen::Vector3d& centre, const Eigen::Vector3d& target, double roll) {
  const Eigen::Vector3d z = (target - centre).normalized(), x = Eigen::Vector3d(0, 1, 0.1).cross(z).normalized();
  Eigen::Matrix3d r;
  r << x.transpose(), z.cross(x).transpose(), z.transpose();
  const Eigen::Quaterniond q =
      Eigen::Quaterniond(Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitZ())) * Eigen::Quaterniond(r);
  return {q, -(q * centre)};
}

inline Eigen::Vector3d corner(double size, size_t k) {
  const double h = 0.5 * size;
  return {k == 1 || k == 2 ? h : -h, k >= 2 ? h : -h, 0};
}

struct Scene {
  MarkerBlock block;
  std::vector<RigidTransform> tags, images;
};

/// Twelve tags on two walls of a corner, ten photographs or more, `height` metres before one of them at least; noise of
/// `sigma` px, stated as such.
inline Scene scene(double sigma, unsigned seed, int photographs = 10,
                   const InteriorOrientation& taken_with = true_camera(), double height = 1.5) {
  Scene s;
  std::mt19937_64 random(seed);
  std::normal_distribution<double> noise(0, sigma > 0 ? sigma : 1);
  MarkerCamera camera;
  camera.camera.width = taken_with.width, camera.camera.height = taken_with.height;
  camera.camera.lens = taken_with.lens;
  s.block.cameras = {camera};
  for (int i = 0; i < 12; ++i) {
    const bool side = i >= 6;
    const double a = 0.3 * (i % 3), b = 0.3 * ((i % 6) / 3);
    const Eigen::Quaterniond turn = side ? Eigen::Quaterniond(Eigen::AngleAxisd(-M_PI / 2, Eigen::Vector3d::UnitY()))
                                         : Eigen::Quaterniond::Identity();
    s.tags.push_back({turn, side ? Eigen::Vector3d(1.1, b, 0.2 + a) : Eigen::Vector3d(a, b, 0)});
    s.block.markers.push_back({"tag36h11", i, 0.12, std::nullopt});
  }
  for (int k = 0; k < photographs; ++k) {
    const int place = photographs == 10 ? k : k * 7 % photographs;  // of more in mixed order
    const double u = (place % 5) / 4.0, v = place / 5 * (5.0 / (photographs - 5));
    s.images.push_back(
        look({-0.6 + 1.0 * u, -0.4 + 1.1 * v, height + 0.3 * u}, {0.55, 0.2, 0.15}, k % 2 ? M_PI / 2 : 0.1));
    s.block.images.push_back({"image" + std::to_string(k) + ".jpg", 0});
    for (size_t m = 0; m < s.tags.size(); ++m) {
      MarkerView view;
      view.image = k, view.marker = static_cast<int>(m);
      bool inside = true;
      for (size_t q = 0; q < 4; ++q) {
        const auto pixel = project(taken_with, s.images.back() * (s.tags[m] * corner(0.12, q)));
        inside = inside && pixel && pixel->minCoeff() > 0 && pixel->x() < 1599 && pixel->y() < 1199;
        if (!inside) break;
        view.corners[q] = *pixel + (sigma > 0 ? Eigen::Vector2d(noise(random), noise(random)) : Eigen::Vector2d(0, 0));
        view.covariances[q] = Eigen::Matrix2d::Identity() * std::pow(sigma > 0 ? sigma : 0.01, 2);
      }
      const Eigen::Vector3d normal = s.tags[m].rotation * Eigen::Vector3d::UnitZ();
      const Eigen::Vector3d sight = (s.images.back().inverse().translation - s.tags[m].translation).normalized();
      if (inside && normal.dot(sight) > 0.2) s.block.views.push_back(view);
    }
  }
  return s;
}

/// Root mean square of the centres after the best rigid motion [m].
inline double error_of(const Scene& s, const MarkerResult& result) {
  std::vector<Eigen::Vector3d> from, to;
  for (const auto& m : result.markers) {
    from.push_back(m.world_from_tag.translation);
    to.push_back(s.tags[m.marker].translation);
  }
  const SimilarityMotion motion = fit_similarity(from, to, false);
  double sum = 0;
  for (size_t i = 0; i < from.size(); ++i) sum += (motion * from[i] - to[i]).squaredNorm();
  return std::sqrt(sum / (3.0 * static_cast<double>(from.size())));
}

/// The scene with nothing but the tags of `keep`.
inline Scene only(Scene s, const std::vector<int>& keep) {
  std::erase_if(s.block.views,
                [&](const MarkerView& v) { return std::find(keep.begin(), keep.end(), v.marker) == keep.end(); });
  return s;
}

}  // namespace plumbline::markers

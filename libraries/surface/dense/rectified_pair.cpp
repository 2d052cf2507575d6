#include "surface/dense/rectified_pair.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace plumbline::surface {

Eigen::Vector3d RectifiedPair::rectified(const Eigen::Vector3d& world) const {
  const Eigen::Vector3d p = rect_from_world * (world - centre);
  return {focal * p.x() / p.z(), focal * p.y() / p.z(), focal * baseline / p.z()};
}

Eigen::Vector3d RectifiedPair::world(const Eigen::Vector3d& r) const {
  const double z = focal * baseline / r.z();
  return centre + rect_from_world.transpose() * Eigen::Vector3d(r.x() / focal * z, r.y() / focal * z, z);
}

std::optional<Eigen::Vector2d> RectifiedPair::source(const View& view, const Eigen::Vector2d& r) const {
  const Eigen::Vector3d ray = rect_from_world.transpose() * Eigen::Vector3d(r.x() / focal, r.y() / focal, 1);
  return project(view.camera, view.cam_from_world.rotation * ray);
}

std::optional<RectifiedPair> rectified_pair(const FacadePlane& plane, const Eigen::Vector2d& place,
                                            const std::vector<View>& views, size_t one, size_t other) {
  const Eigen::Vector3d at(place.x(), place.y(), 0);
  const auto a = map_at(views[one], plane, at, 8), b = map_at(views[other], plane, at, 8);
  if (!a || !b) return std::nullopt;
  RectifiedPair pair;
  pair.left = one, pair.right = other;
  pair.centre = views[one].cam_from_world.inverse().translation;
  const Eigen::Vector3d second = views[other].cam_from_world.inverse().translation, point = plane.world(at);
  const double angle =
      std::acos(std::clamp((pair.centre - point).normalized().dot((second - point).normalized()), -1.0, 1.0));
  if (!(angle > 0.05 && angle < 0.87)) return std::nullopt;
  pair.baseline = (second - pair.centre).norm();
  const Eigen::Vector3d x = (second - pair.centre) / pair.baseline;
  Eigen::Vector3d z = -plane.axes.col(2);
  z -= z.dot(x) * x;
  if (z.norm() < 0.7) return std::nullopt;
  z.normalize();
  pair.rect_from_world.row(0) = x.transpose(), pair.rect_from_world.row(1) = z.cross(x).transpose(),
  pair.rect_from_world.row(2) = z.transpose();
  pair.depth = z.dot(point - pair.centre);
  if (!(pair.depth > 0)) return std::nullopt;
  pair.focal = pair.depth / std::max(a->ground_pixel(), b->ground_pixel());
  return pair;
}

std::vector<RectifiedPair> pairs_for(const FacadePlane& plane, const Eigen::Vector2d& place,
                                     const std::vector<View>& views, int each, size_t most) {
  struct Candidate {
    RectifiedPair pair;
    double off;
  };
  std::vector<Candidate> candidates;
  const std::vector<size_t> own = from_own_places(plane, place, views);
  for (size_t i = 0; i < own.size(); ++i)
    for (size_t j = i + 1; j < own.size(); ++j)
      if (const auto pair = rectified_pair(plane, place, views, own[i], own[j]))
        candidates.push_back({*pair, std::abs(std::log(pair->baseline / pair->depth / 0.27))});
  std::stable_sort(candidates.begin(), candidates.end(), [](const auto& a, const auto& b) { return a.off < b.off; });
  std::vector<int> used(views.size());
  std::vector<RectifiedPair> pairs;
  for (const Candidate& candidate : candidates) {
    int &left = used[candidate.pair.left], &right = used[candidate.pair.right];
    if (left >= each || right >= each || pairs.size() >= most) continue;
    ++left, ++right;
    pairs.push_back(candidate.pair);
  }
  return pairs;
}

}  // namespace plumbline::surface

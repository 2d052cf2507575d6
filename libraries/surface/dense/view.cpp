#include "surface/dense/view.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace plumbline::surface {
namespace {

GreyImage halved(const GreyImage& image) {
  GreyImage half;
  half.width = image.width / 2, half.height = image.height / 2;
  half.pixels.resize(static_cast<size_t>(half.width) * half.height);
  for (int y = 0; y < half.height; ++y) {
    const std::uint8_t* upper = image.pixels.data() + static_cast<size_t>(2 * y) * image.width;
    const std::uint8_t* lower = upper + image.width;
    std::uint8_t* out = half.pixels.data() + static_cast<size_t>(y) * half.width;
    for (int x = 0; x < half.width; ++x)
      out[x] = static_cast<std::uint8_t>((upper[2 * x] + upper[2 * x + 1] + lower[2 * x] + lower[2 * x + 1] + 2) / 4);
  }
  return half;
}

}  // namespace

std::optional<LocalMap> map_at(const View& view, const FacadePlane& plane, const Eigen::Vector3d& place,
                               double margin) {
  const Eigen::Vector3d turned = view.cam_from_world.rotation * plane.world(place);
  const Eigen::Vector3d in_camera = turned + view.cam_from_world.translation;
  const auto seen = project_with_slope(view.camera, in_camera);
  if (!seen) return std::nullopt;
  // Distortion polynomials turn back far outside of the image and would bring places from there into it.
  const Eigen::Matrix2d across = seen->by_point.leftCols<2>();
  if (!(across(0, 0) > 0 && across.determinant() > 0)) return std::nullopt;
  const auto inside = [&](double value, int size) { return value >= margin && value <= size - 1 - margin; };
  if (!inside(seen->pixel.x(), view.camera.width) || !inside(seen->pixel.y(), view.camera.height)) return std::nullopt;
  const Eigen::Matrix3d cam_from_plane = view.cam_from_world.rotation.toRotationMatrix() * plane.axes;
  if (in_camera.dot(cam_from_plane.col(2)) >= 0) return std::nullopt;  // from behind
  LocalMap map;
  map.pixel = seen->pixel;
  map.by_place = seen->by_point * cam_from_plane;
  map.by_image << -seen->by_point * skew(turned), seen->by_point, Eigen::Matrix2d::Identity();
  map.by_camera = pixel_by_parameters(view.camera, in_camera.x() / in_camera.z(), in_camera.y() / in_camera.z());
  return map;
}

std::vector<size_t> from_own_places(const FacadePlane& plane, const Eigen::Vector2d& place,
                                    const std::vector<View>& views) {
  std::vector<size_t> own;
  std::vector<Eigen::Vector2d> slopes;
  for (size_t k = 0; k < views.size(); ++k) {
    const auto map = map_at(views[k], plane, {place.x(), place.y(), 0}, -1e6);
    if (!map) continue;
    const Eigen::Vector2d slope = map->parallax();
    if (std::any_of(slopes.begin(), slopes.end(),
                    [&](const auto& other) { return (other - slope).norm() < kOnePlace; }))
      continue;
    own.push_back(k), slopes.push_back(slope);
  }
  return own;
}

Pyramid pyramid_of(GreyImage image) {
  Pyramid pyramid;
  pyramid.level[0] = std::move(image);
  for (int l = 1; l < Pyramid::levels; ++l) pyramid.level[l] = halved(pyramid.level[l - 1]);
  return pyramid;
}

}  // namespace plumbline::surface

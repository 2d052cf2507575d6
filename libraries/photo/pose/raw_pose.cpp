#include "photo/pose/raw_pose.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>

namespace plumbline::pose {

namespace {

/// Area of a tag in the image [px²], by Gauss's formula.
double area(const TagView& view) {
  double twice = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const Eigen::Vector2d &a = view.pixels[i], &b = view.pixels[(i + 1) % 4];
    twice += a.x() * b.y() - a.y() * b.x();
  }
  return 0.5 * std::abs(twice);
}

/// Of the corners of `sample` [px²]; infinite if one is behind the camera.
double sum_of_squares(const BrownCamera& camera, const std::vector<const TagView*>& sample,
                      const RigidTransform& pose) {
  double sum = 0;
  for (const TagView* tag : sample)
    for (int i = 0; i < 4; ++i) {
      const auto pixel = project(camera, pose * tag->corner_in_world(i));
      if (!pixel) return std::numeric_limits<double>::infinity();
      sum += (*pixel - tag->pixels[i]).squaredNorm();
    }
  return sum;
}

}  // namespace

TagPose raw_tag_pose(const BrownCamera& camera, const std::vector<TagView>& views, const TagPoseSolver& solver,
                     int tags) {
  if (static_cast<int>(views.size()) < tags)
    throw NoTagPose("a raw pose of " + std::to_string(tags) + " tags needs as many, there are " +
                    std::to_string(views.size()));
  // As in estimate_tag_pose(): coordinates of millions of metres would cost the solvers their digits.
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (const TagView& view : views) centre += view.anchor_in_world / static_cast<double>(views.size());
  std::vector<TagView> local = views;
  for (TagView& view : local) {
    view.anchor_in_world -= centre;
    view.world_from_tag.translation -= centre;
  }
  std::vector<std::size_t> order(views.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return area(views[a]) > area(views[b]); });
  TagPose best;
  best.inliers.assign(views.size(), false);
  std::vector<const TagView*> sample;
  for (int k = 0; k < tags; ++k) {
    sample.push_back(&local[order[k]]);
    best.inliers[order[k]] = true;
  }
  double least = std::numeric_limits<double>::infinity();
  for (const RigidTransform& pose : solver(sample)) {
    if (!pose.translation.allFinite() || !pose.rotation.coeffs().allFinite()) continue;
    const double squares = sum_of_squares(camera, sample, pose);
    if (squares < least) least = squares, best.cam_from_world = pose;
  }
  if (!std::isfinite(least))
    throw NoTagPose("the solver gives no pose of " + std::to_string(tags) + (tags == 1 ? " tag" : " tags"));
  best.cam_from_world.translation -= best.cam_from_world.rotation * centre;
  best.inlier_count = tags;
  best.covariance.setZero();
  best.rms = std::sqrt(least / (8.0 * tags));
  return best;
}

}  // namespace plumbline::pose

#include "photo/block/image_plan.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include "plumbline/stop.hpp"

namespace plumbline::block {

namespace {

using Point = Eigen::Vector2d;

/// Area of the convex hull (Andrew 1979, monotone chain) [px²].
double hull_area(std::vector<Point> points) {
  if (points.size() < 3) return 0;
  std::sort(points.begin(), points.end(),
            [](const Point& a, const Point& b) { return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y(); });
  const auto turn = [](const Point& o, const Point& a, const Point& b) {
    return (a - o).x() * (b - o).y() - (a - o).y() * (b - o).x();
  };
  std::vector<Point> hull;
  for (int side = 0; side < 2; ++side) {
    const std::size_t first = hull.size();
    for (const Point& p : points) {
      while (hull.size() >= first + 2 && turn(hull[hull.size() - 2], hull.back(), p) <= 0) hull.pop_back();
      hull.push_back(p);
    }
    hull.pop_back();
    std::reverse(points.begin(), points.end());
  }
  double twice = 0;
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const Point &a = hull[i], &b = hull[(i + 1) % hull.size()];
    twice += a.x() * b.y() - a.y() * b.x();
  }
  return std::abs(twice) / 2;
}

/// Where the camera draws a point; nothing where its distortion has turned back before it gets there: what the
/// polynomial makes of such a ray may lie in the image, the lens draws it outside.
std::optional<Point> drawn(const BrownCamera& camera, const Eigen::Vector3d& point_in_camera) {
  const auto pixel = project(camera, point_in_camera);
  if (!pixel) return std::nullopt;
  const auto ray = unproject(camera, *pixel);
  const Point given = point_in_camera.head<2>() / point_in_camera.z();
  if (!ray || !((*ray - given).norm() < 1e-6 * (1 + given.norm()))) return std::nullopt;
  return pixel;
}

/// Corners of a tag in an image; fewer than four if not all of them fall into it.
std::vector<Point> corners_in(const BoundProblem& problem, const RigidTransform& cam_from_world, std::size_t plate) {
  std::vector<Point> corners;
  const BoundPlate& p = problem.plates[plate];
  for (const Eigen::Vector3d& corner : p.corners_in_plate) {
    const auto pixel = drawn(problem.camera, cam_from_world * (p.position + p.world_from_plate * corner));
    if (pixel && pixel->x() >= 0 && pixel->y() >= 0 && pixel->x() <= problem.camera.width - 1 &&
        pixel->y() <= problem.camera.height - 1)
      corners.push_back(*pixel);
  }
  return corners;
}

std::vector<std::vector<BoundTag>> tags_by_image(const BoundProblem& problem) {
  std::vector<std::vector<BoundTag>> tags(problem.cam_from_world.size());
  for (const BoundTag& tag : problem.tags) tags[tag.image].push_back(tag);
  return tags;
}

std::vector<WeakImage> weak_images(const BoundProblem& problem, const std::vector<std::vector<BoundTag>>& tags,
                                   const ImagePlanOptions& options) {
  std::vector<WeakImage> weak;
  const double area = static_cast<double>(problem.camera.width) * problem.camera.height;
  for (std::size_t i = 0; i < tags.size(); ++i) {
    std::set<std::size_t> plates;
    std::vector<Point> corners;
    for (const BoundTag& tag : tags[i]) {
      plates.insert(tag.plate);
      for (const Point& corner : corners_in(problem, problem.cam_from_world[i], tag.plate)) corners.push_back(corner);
    }
    const WeakImage image{i, static_cast<int>(plates.size()), hull_area(corners) / area};
    if (image.plates < options.fewest_plates || image.coverage < options.least_coverage) weak.push_back(image);
  }
  return weak;
}

}  // namespace

ImagePlan plan_images(const BoundProblem& problem, const TagBound& bound, const std::vector<std::size_t>& wanted,
                      const ImagePlanOptions& options) {
  ImagePlan plan;
  const Eigen::MatrixXd covariance = bound.anchors();
  double sum = 0, sum_3d = 0;
  for (const std::size_t j : wanted) {
    const auto row = static_cast<Eigen::Index>(3 * j + 2);
    sum += covariance(row, row);
    sum_3d += covariance.diagonal().segment<3>(row - 2).sum();
    if (std::sqrt(covariance(row, row)) <= plan.worst_sigma) continue;
    plan.worst = j;
    plan.worst_sigma = std::sqrt(covariance(row, row));
  }
  const double count = static_cast<double>(wanted.size());
  plan.rmse_z = std::sqrt(sum / count);
  plan.rmse_3d = std::sqrt(sum_3d / count);
  const auto tags = tags_by_image(problem);
  plan.weak = weak_images(problem, tags, options);

  const auto consider = [&](Addition::Kind kind, std::size_t of, const BoundInformation& more, double cost) {
    stop_point();
    const double left = std::max(0.0, sum - bound.height_gain(more, wanted).sum());
    Addition addition{kind, of, std::sqrt(left / count), 0};
    addition.per_cost = (1 - addition.rmse_z / plan.rmse_z) / cost;
    plan.additions.push_back(addition);
  };
  const RigidTransform quarter{Eigen::Quaterniond(Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitZ())),
                               Eigen::Vector3d::Zero()};
  for (std::size_t i = 0; i < tags.size(); ++i) {
    if (tags[i].empty()) continue;
    consider(Addition::Kind::again, i, bound.of_image(problem.cam_from_world[i], tags[i]), 1);
    const RigidTransform rolled = quarter * problem.cam_from_world[i];
    std::vector<BoundTag> still;
    for (const BoundTag& tag : tags[i])
      if (corners_in(problem, rolled, tag.plate).size() == 4) still.push_back(tag);
    if (!still.empty()) consider(Addition::Kind::rolled, i, bound.of_image(rolled, still), 1);
  }
  for (std::size_t j = 0; j < problem.plates.size(); ++j) {
    const auto row = static_cast<Eigen::Index>(3 * j);
    const auto one_of = [&](const std::vector<std::size_t>& plates) {
      return std::find(plates.begin(), plates.end(), j) != plates.end();
    };
    if (!std::isfinite(covariance(row, row)) || one_of(problem.control) || one_of(wanted)) continue;
    consider(Addition::Kind::survey, j, bound.of_survey(j, options.survey_sigma), options.survey_cost);
  }
  std::stable_sort(plan.additions.begin(), plan.additions.end(),
                   [](const Addition& a, const Addition& b) { return a.per_cost > b.per_cost; });
  return plan;
}

}  // namespace plumbline::block

// Approximate values of a tag block: good enough for Levenberg-Marquardt, not more.
#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

#include "photo/block/tag_block_model.hpp"

namespace plumbline::block {
namespace {

struct Ray {
  Eigen::Vector3d from, direction;  ///< world, unit length
};

/// Observations with their corners as normalised image coordinates.
struct View {
  int image = 0, plate = 0, observation = 0;
  std::array<Eigen::Vector2d, 4> corners;
};

struct Placed {
  std::vector<std::optional<RigidTransform>> cam_from_world;    ///< by image
  std::vector<std::optional<RigidTransform>> world_from_plate;  ///< by plate
};

Ray ray_of(const RigidTransform& cam_from_world, const Eigen::Vector2d& corner) {
  const RigidTransform world_from_cam = cam_from_world.inverse();
  return {world_from_cam.translation, (world_from_cam.rotation * corner.homogeneous().eval()).normalized()};
}

/// The translation that brings points fixed to a body (offsets) closest to their rays: Σ ‖(I − ddᵀ)(t + offset −
/// from)‖² → min.
Eigen::Vector3d intersect(const std::vector<Ray>& rays, const std::vector<Eigen::Vector3d>& offsets) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (size_t i = 0; i < rays.size(); ++i) {
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - rays[i].direction * rays[i].direction.transpose();
    normal += across;
    right += across * (rays[i].from - offsets[i]);
  }
  return normal.ldlt().solve(right);
}

/// Rotation of a plate from its four corners in the world; nothing if they don't look like a square of the tag's size.
std::optional<Eigen::Quaterniond> rotation_of_square(const std::array<Eigen::Vector3d, 4>& c, double size) {
  Eigen::Vector3d x = c[1] - c[0] + c[2] - c[3], y = c[3] - c[0] + c[2] - c[1];
  const double width = 0.5 * x.norm(), height = 0.5 * y.norm();
  if (std::abs(width / size - 1) > 0.2 || std::abs(height / size - 1) > 0.2) return std::nullopt;
  x.normalize();
  y = (y - y.dot(x) * x).normalized();
  Eigen::Matrix3d rotation;
  rotation << x, y, x.cross(y);
  return Eigen::Quaterniond(rotation);
}

/// Plate from all oriented images that see it. With a single one, or rays too parallel, the rotation is the nominal
/// one.
std::optional<RigidTransform> place_plate(const TagPlate& plate, const std::vector<const View*>& views,
                                          const Placed& placed) {
  constexpr double smallest_parallax = 0.035;  // [rad], 2 degrees
  std::array<std::vector<Ray>, 4> rays;
  for (const View* view : views)
    if (const auto& pose = placed.cam_from_world[view->image])
      for (size_t k = 0; k < 4; ++k) rays[k].push_back(ray_of(*pose, view->corners[k]));
  if (rays[0].empty()) return std::nullopt;
  double parallax = 0;
  for (const Ray& a : rays[0]) parallax = std::max(parallax, a.direction.cross(rays[0][0].direction).norm());
  RigidTransform world_from_plate{plate.nominal_rotation.normalized(), Eigen::Vector3d::Zero()};
  if (parallax > smallest_parallax) {
    std::array<Eigen::Vector3d, 4> corners;
    for (size_t k = 0; k < 4; ++k)
      corners[k] = intersect(rays[k], std::vector<Eigen::Vector3d>(rays[k].size(), Eigen::Vector3d::Zero()));
    if (const auto rotation = rotation_of_square(corners, plate.plate.tag_size)) world_from_plate.rotation = *rotation;
  }
  std::vector<Ray> all;
  std::vector<Eigen::Vector3d> offsets;
  const auto corners = tag_corners_in_plate(plate.plate);
  for (size_t k = 0; k < 4; ++k)
    for (const Ray& ray : rays[k]) {
      all.push_back(ray);
      offsets.push_back(world_from_plate.rotation * corners[k]);
    }
  world_from_plate.translation = intersect(all, offsets);
  return world_from_plate;
}

/// Camera from the tag's own frame (centre, plate axes) by the homography of its four corners.
std::optional<RigidTransform> camera_from_tag(const std::array<Eigen::Vector2d, 4>& seen, double size) {
  Eigen::Matrix<double, 8, 8> system = Eigen::Matrix<double, 8, 8>::Zero();
  Eigen::Matrix<double, 8, 1> right;
  const double h = 0.5 * size;
  const std::array<Eigen::Vector2d, 4> square = {Eigen::Vector2d(-h, -h), {h, -h}, {h, h}, {-h, h}};
  for (Eigen::Index k = 0; k < 4; ++k) {
    const Eigen::Vector2d& p = square[k];
    const Eigen::Vector2d& q = seen[k];
    system.row(2 * k) << p.x(), p.y(), 1, 0, 0, 0, -q.x() * p.x(), -q.x() * p.y();
    system.row(2 * k + 1) << 0, 0, 0, p.x(), p.y(), 1, -q.y() * p.x(), -q.y() * p.y();
    right.segment<2>(2 * k) = q;
  }
  const Eigen::Matrix<double, 8, 1> v = system.partialPivLu().solve(right);
  if (!v.allFinite()) return std::nullopt;
  Eigen::Vector3d a(v(0), v(3), v(6)), b(v(1), v(4), v(7)), t(v(2), v(5), 1);
  const double scale = 2 / (a.norm() + b.norm());
  if (!std::isfinite(scale)) return std::nullopt;
  // The columns are neither exactly unit nor exactly perpendicular; turn both by the same angle until they are.
  const Eigen::Vector3d sum = (a.normalized() + b.normalized()).normalized(),
                        difference = (a.normalized() - b.normalized()).normalized();
  Eigen::Matrix3d rotation;
  rotation.col(0) = (sum + difference) / std::sqrt(2.0);
  rotation.col(1) = (sum - difference) / std::sqrt(2.0);
  rotation.col(2) = rotation.col(0).cross(rotation.col(1));
  return RigidTransform{Eigen::Quaterniond(rotation), scale * t};
}

/// Sum of distances in the normalised image, each cut off at 0.05, of all placed corners an image sees.
double misfit(const RigidTransform& cam_from_world, const TagBlock& block, const std::vector<const View*>& views,
              const Placed& placed) {
  constexpr double cut_off = 0.05;
  double sum = 0;
  for (const View* view : views) {
    const auto& plate = placed.world_from_plate[view->plate];
    if (!plate) continue;
    const auto corners = tag_corners_in_plate(block.plates[view->plate].plate);
    for (size_t k = 0; k < 4; ++k) {
      const Eigen::Vector3d p = cam_from_world * (*plate * corners[k]);
      sum += p.z() > 0 ? std::min(cut_off, (p.hnormalized() - view->corners[k]).norm()) : cut_off;
    }
  }
  return sum;
}

/// Pose of an image from the placed plates it sees: the tag whose own pose explains all of them best.
std::optional<RigidTransform> orient_image(const TagBlock& block, const std::vector<const View*>& views,
                                           const Placed& placed, int needed) {
  std::optional<RigidTransform> best;
  double smallest = std::numeric_limits<double>::infinity();
  int known = 0;
  for (const View* view : views) {
    const auto& plate = placed.world_from_plate[view->plate];
    if (!plate) continue;
    ++known;
    const MarkerPlate& shape = block.plates[view->plate].plate;
    const auto tag = camera_from_tag(view->corners, shape.tag_size);
    if (!tag) continue;
    const RigidTransform plate_from_tag{Eigen::Quaterniond::Identity(), shape.tag_centre_in_plate};
    const RigidTransform pose = *tag * (*plate * plate_from_tag).inverse();
    const double distance = misfit(pose, block, views, placed);
    if (distance < smallest) {
      smallest = distance;
      best = pose;
    }
  }
  return known >= needed ? best : std::nullopt;
}

/// Whether the corners enclose more than a pixel.
bool is_quadrilateral(const std::array<Eigen::Vector2d, 4>& c) {
  const Eigen::Vector2d a = c[2] - c[0], b = c[3] - c[1];
  return std::abs(a.x() * b.y() - a.y() * b.x()) > 2;
}

std::vector<View> undistort(const TagBlock& block, const std::vector<bool>& use, std::vector<std::string>& left_out) {
  std::vector<View> views;
  for (size_t i = 0; i < block.observations.size(); ++i) {
    if (!use[i]) continue;
    const TagObservation& seen = block.observations[i];
    const TagImage& image = block.images[seen.image];
    const BrownCamera& camera = block.cameras[image.camera].interior;
    View view{seen.image, seen.plate, static_cast<int>(i), {}};
    bool inside = true;
    for (size_t k = 0; k < 4; ++k) {
      const auto p = unproject(camera, seen.corners[k] - image.principal_point);
      inside = inside && p.has_value();
      if (p) view.corners[k] = *p;
    }
    const bool has_area = is_quadrilateral(seen.corners);
    if (inside && has_area)
      views.push_back(view);
    else
      left_out.push_back(
          "the tag of " + block.plates[seen.plate].anchor + " in " + image.name +
          (has_area ? ": outside what the distortion model can invert" : ": its corners enclose no area"));
  }
  return views;
}

/// Alternates between placing plates and orienting images until nothing is added. Images with two known plates go
/// first: a single tag seen frontally has two poses that fit almost equally well.
Placed grow(const TagBlock& block, const std::vector<std::vector<const View*>>& by_image,
            const std::vector<std::vector<const View*>>& by_plate) {
  Placed placed;
  placed.world_from_plate.resize(block.plates.size());
  for (const auto& image : block.images) placed.cam_from_world.push_back(image.cam_from_world);
  bool oriented = false;
  for (bool added = true; added;) {
    added = false;
    for (size_t j = 0; j < by_plate.size(); ++j)
      if (!placed.world_from_plate[j] &&
          (placed.world_from_plate[j] = place_plate(block.plates[j], by_plate[j], placed)))
        added = true;
    for (int needed : {2, 1})
      for (size_t i = 0; i < by_image.size() && !(needed == 1 && added); ++i)
        if (!placed.cam_from_world[i] && (placed.cam_from_world[i] = orient_image(block, by_image[i], placed, needed)))
          added = oriented = true;
  }
  // Now that every image is known, every plate is placed anew from all of them.
  for (size_t j = 0; j < by_plate.size() && oriented; ++j)
    placed.world_from_plate[j] = place_plate(block.plates[j], by_plate[j], placed);
  return placed;
}

/// Pairs whose tag would lie behind the camera cannot enter an adjustment: either value is wrong.
void drop_impossible(const TagBlock& block, const Placed& placed, std::vector<View>& views,
                     std::vector<std::string>& left_out) {
  std::erase_if(views, [&](const View& view) {
    const auto& pose = placed.cam_from_world[view.image];
    const auto& plate = placed.world_from_plate[view.plate];
    if (!pose || !plate) return false;
    for (const auto& corner : tag_corners_in_plate(block.plates[view.plate].plate))
      if (!((*pose * (*plate * corner)).z() > 0.05)) {
        left_out.push_back("the tag of " + block.plates[view.plate].anchor + " in " + block.images[view.image].name +
                           ": behind the camera by the approximate values; a wrong pose or a wrong tag number");
        return true;
      }
    return false;
  });
}

}  // namespace

TagStart start_tag_block(const TagBlock& block, const std::vector<bool>& use, std::vector<std::string>& left_out) {
  std::vector<View> views = undistort(block, use, left_out);
  std::vector<std::vector<const View*>> by_image(block.images.size()), by_plate(block.plates.size());
  for (const View& view : views) {
    by_image[view.image].push_back(&view);
    by_plate[view.plate].push_back(&view);
  }
  Placed placed = grow(block, by_image, by_plate);
  drop_impossible(block, placed, views, left_out);
  std::vector<bool> image_used(block.images.size()), plate_used(block.plates.size());
  for (const View& view : views)
    if (placed.cam_from_world[view.image] && placed.world_from_plate[view.plate])
      image_used[view.image] = plate_used[view.plate] = true;
  std::vector<bool> plate_seen(block.plates.size()), image_saw(block.images.size());
  for (const auto& seen : block.observations) plate_seen[seen.plate] = image_saw[seen.image] = true;
  TagStart start;
  for (size_t i = 0; i < image_used.size(); ++i)
    if (image_used[i])
      start.images.push_back(static_cast<int>(i));
    else
      left_out.push_back(block.images[i].name + (!image_saw[i]         ? ": no tag of a known plate"
                                                 : by_image[i].empty() ? ": all its tags were left out as blunders"
                                                                       : ": sees no plate that could be placed"));
  for (size_t j = 0; j < plate_used.size(); ++j)
    if (plate_used[j])
      start.plates.push_back(static_cast<int>(j));
    else
      left_out.push_back(block.plates[j].anchor +
                         (!plate_seen[j] ? ": its tag is in no image"
                          : by_plate[j].empty()
                              ? ": its tag contradicts all others in every image: exchanged with another plate, of "
                                "another size, or not where the plate table has it on its plate"
                              : ": its tag is in no oriented image"));
  if (start.images.size() < 2)
    throw std::runtime_error("a block needs at least 2 oriented images that see plates, this one has " +
                             std::to_string(start.images.size()) + " of " + std::to_string(block.images.size()) +
                             (left_out.empty() ? "" : " (" + left_out.front() + ")"));
  for (int i : start.images) start.cam_from_world.push_back(*placed.cam_from_world[i]);
  for (int j : start.plates) start.world_from_plate.push_back(*placed.world_from_plate[j]);
  for (const View& view : views)
    if (placed.cam_from_world[view.image] && placed.world_from_plate[view.plate])
      start.observations.push_back(view.observation);
  return start;
}

}  // namespace plumbline::block

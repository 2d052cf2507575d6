#include "camera.hpp"

#include <fmt/core.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "camera_profiles.hpp"  // generated from profiles/*.yaml
#include "geometry/random.hpp"
#include "geometry/similarity.hpp"
#include "base/text/one_document.hpp"

namespace plumbline::simulate {
namespace {

constexpr double kMinimumTagEdge = 20;  // [px]: nobody decodes smaller ones reliably

/// Radius in normalised coordinates beyond which a point cannot be in the image; without it the distortion polynomial
/// could fold points from far outside back in.
double field_radius(const BrownCamera& camera) {
  double radius = 0;
  for (const double x : {0.0, camera.width - 1.0}) {
    for (const double y : {0.0, camera.height - 1.0}) {
      radius = std::max(radius, std::hypot((x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy));
    }
  }
  return 1.15 * radius;
}

CameraProfile parse_profile(const std::string& name, const char* text) {
  const YAML::Node y = text::load_one_document(text);
  CameraProfile p;
  p.name = name;
  p.make = y["make"].as<std::string>();
  p.model = y["model"].as<std::string>();
  p.pixel_pitch = 1e-6 * y["pixel_pitch_um"].as<double>();
  p.focal_length = 1e-3 * y["focal_length_mm"].as<double>();
  BrownCamera& c = p.nominal;
  c.width = y["width"].as<int>();
  c.height = y["height"].as<int>();
  c.fx = c.fy = p.focal_length / p.pixel_pitch;
  c.cx = 0.5 * (c.width - 1) + y["principal_point_offset_px"][0].as<double>();
  c.cy = 0.5 * (c.height - 1) + y["principal_point_offset_px"][1].as<double>();
  const YAML::Node d = y["distortion"], s = y["calibration_sigma"];
  c.k1 = d["k1"].as<double>(), c.k2 = d["k2"].as<double>(), c.k3 = d["k3"].as<double>();
  c.p1 = d["p1"].as<double>(), c.p2 = d["p2"].as<double>();
  const double f = s["f_px"].as<double>(), centre = s["c_px"].as<double>(), tangential = s["p"].as<double>();
  p.calibration_sigmas = {
      f, f, centre, centre, s["k1"].as<double>(), s["k2"].as<double>(), s["k3"].as<double>(), tangential, tangential};
  p.blur = y["blur_px"].as<double>();
  p.vignetting = y["vignetting"].as<double>();
  p.read_noise = y["noise"]["read"].as<double>();
  p.shot_noise = y["noise"]["shot"].as<double>();
  p.jpeg_quality = y["jpeg_quality"].as<int>();
  p.distance = y["distance_m"].as<double>();
  return p;
}

/// Where image `index` of a floor stands, where it looks and how it is rolled, before the photographer's scatter.
struct Aim {
  Eigen::Vector3d position, target;
  double roll = 0;
};

Aim plan_image(const Building& b, const CameraNetworkOptions& options, double distance, int floor, int index) {
  const double h = b.storey_height, middle = h * (floor - 0.5), centre = 0.5 * b.width;
  const double u = (index + 0.5) / options.images_per_floor;  // left to right along the facade
  if (!options.convergent) {
    const double x = 0.5 * b.options.spacing + u * (b.width - b.options.spacing);
    return {{x, -distance, middle}, {x, 0, middle}, 0};
  }
  const double x = -0.5 + u * (b.width + 1.0);
  const double aim_x = centre - 0.25 * (x - centre);
  const bool high = (index / 2) % 2 == 1;
  const double z = middle + (high ? 0.35 : -0.35) * h;
  if (index % 2 == 0) {
    return {{x, -distance, z}, {aim_x, 0, middle}, index % 8 == 6 ? std::numbers::pi : 0.0};
  }
  // Rolled images look at the boundary with a neighbour, in turns above and below, and see rows of both floors.
  const bool up = b.options.floors > 1 && (floor == 1 || (floor < b.options.floors && high));
  const bool down = b.options.floors > 1 && !up;
  const double aim_z = up ? h * floor : down ? h * (floor - 1) : middle;
  const double roll = (index % 4 == 1 ? 0.5 : -0.5) * std::numbers::pi;
  return {{x, -distance, z}, {aim_x, 0, aim_z}, roll};
}

std::string image_name(int floor, int index) { return fmt::format("F{:02}-{:02}.jpg", floor, index + 1); }

}  // namespace

std::vector<std::string> camera_profile_names() {
  std::vector<std::string> names;
  for (const auto& profile : embedded_camera_profiles) names.emplace_back(profile.name);
  return names;
}

CameraProfile camera_profile(const std::string& name) {
  std::string known;
  for (const auto& profile : embedded_camera_profiles) {
    if (name == profile.name) return parse_profile(name, profile.yaml);
    known += (known.empty() ? "" : ", ") + std::string(profile.name);
  }
  throw std::invalid_argument("there is no camera profile '" + name + "'; known are " + known);
}

SimulatedCamera make_camera(const CameraProfile& profile, std::uint64_t seed) {
  SimulatedCamera camera{profile, profile.nominal, profile.nominal};
  Random random(seed, "camera");
  const double focal_change = random.normal(2e-3 * profile.nominal.fx);  // no two lenses are equal
  camera.truth.fx += focal_change;
  camera.truth.fy += focal_change;
  camera.truth.cx += random.normal(5);
  camera.truth.cy += random.normal(5);

  camera.calibration = camera.truth;
  auto values = camera.truth.parameters();
  for (std::size_t i = 0; i < values.size(); ++i) values[i] += random.normal(profile.calibration_sigmas[i]);
  camera.calibration.set_parameters(values);
  return camera;
}

RigidTransform look_at(const Eigen::Vector3d& position, const Eigen::Vector3d& target, double roll) {
  const Eigen::Vector3d forward = (target - position).normalized();
  const Eigen::Vector3d right = forward.cross(Eigen::Vector3d::UnitZ()).normalized();
  Eigen::Matrix3d rows;
  rows.row(0) = right;
  rows.row(1) = forward.cross(right);
  rows.row(2) = forward;
  const Eigen::Matrix3d rotation = Eigen::AngleAxisd(-roll, Eigen::Vector3d::UnitZ()).toRotationMatrix() * rows;
  const Eigen::Quaterniond q = Eigen::Quaterniond(rotation).normalized();
  return {q, -(q * position)};
}

std::vector<VisibleTag> visible_tags(const Building& building, const BrownCamera& camera,
                                     const RigidTransform& camera_from_building, double margin,
                                     const Obstruction& obstruction, const DepthDistortion& depth_distortion) {
  const double limit = field_radius(camera);
  const Eigen::Vector3d centre = camera_from_building.inverse().translation;
  std::vector<VisibleTag> visible;
  for (std::size_t index = 0; index < building.anchors.size(); ++index) {
    const Anchor& anchor = building.anchors[index];
    if (!tag_is_free(obstruction, building, index, centre)) continue;
    const Eigen::Vector3d normal = anchor.building_from_plate.rotation * Eigen::Vector3d::UnitZ();
    if (normal.dot((centre - anchor.built).normalized()) < std::cos(70.0 / 180.0 * std::numbers::pi)) continue;
    if (building.wings.size() > 1 && !free_sight(building, centre, anchor.built, anchor.wing)) continue;
    VisibleTag tag{&anchor, {}};
    bool whole = true;
    const auto corners = anchor.tag_corners();
    for (std::size_t i = 0; i < 4 && whole; ++i) {
      const Eigen::Vector3d p = camera_from_building * (anchor.building_from_plate * corners[i]);
      BrownCamera at_depth = camera;
      at_depth.k1 += depth_distortion.slope * (1 / p.z() - 1 / depth_distortion.reference);
      const auto pixel = p.z() > 0.1 && p.head<2>().norm() < limit * p.z() ? project(at_depth, p) : std::nullopt;
      whole = pixel && pixel->x() >= margin && pixel->y() >= margin && pixel->x() <= camera.width - 1 - margin &&
              pixel->y() <= camera.height - 1 - margin;
      if (whole) tag.corners[i] = *pixel;
    }
    if (whole && (tag.corners[0] - tag.corners[1]).norm() >= kMinimumTagEdge &&
        (tag.corners[1] - tag.corners[2]).norm() >= kMinimumTagEdge) {
      visible.push_back(tag);
    }
  }
  return visible;
}

namespace {

/// The pose turned about its projection centre until the border of the image goes through the centre of the tag that
/// was nearest to it.
RigidTransform cutting_a_tag(const Building& building, const BrownCamera& camera, const RigidTransform& pose) {
  double nearest = std::numeric_limits<double>::infinity();
  Eigen::Vector2d from, to;
  for (const VisibleTag& tag : visible_tags(building, camera, pose)) {
    const Eigen::Vector2d centre = 0.25 * (tag.corners[0] + tag.corners[1] + tag.corners[2] + tag.corners[3]);
    for (const Eigen::Vector2d& border :
         {Eigen::Vector2d(0, centre.y()), Eigen::Vector2d(centre.x(), 0), Eigen::Vector2d(camera.width - 1, centre.y()),
          Eigen::Vector2d(centre.x(), camera.height - 1)})
      if (const double distance = (border - centre).norm(); distance < nearest)
        nearest = distance, from = centre, to = border;
  }
  if (std::isinf(nearest)) return pose;
  const auto now = unproject(camera, from), then = unproject(camera, to);
  if (!now || !then) return pose;
  const RigidTransform turn{shortest_rotation(now->homogeneous(), then->homogeneous()), Eigen::Vector3d::Zero()};
  return turn * pose;
}

}  // namespace

std::vector<CameraStation> plan_camera_stations(const Building& building, const SimulatedCamera& camera,
                                                const CameraNetworkOptions& options, std::uint64_t seed) {
  if (options.images_per_floor < 4 || options.images_per_floor > 100) {
    throw std::invalid_argument("images_per_floor is " + std::to_string(options.images_per_floor) +
                                ", it must be 4 to 100");
  }
  const double distance = options.distance > 0 ? options.distance : camera.profile.distance;
  std::vector<CameraStation> stations;
  for (int floor = 1; floor <= building.options.floors; ++floor) {
    for (int index = 0; index < options.images_per_floor; ++index) {
      const Aim aim = plan_image(building, options, distance, floor, index);
      CameraStation station{image_name(floor, index), floor, {}};
      Random random(seed, station.image);
      const Eigen::Vector3d position = aim.position + random.normal3(0.12);
      const Eigen::Vector3d target = aim.target + random.normal3(0.10);
      station.camera_from_building = look_at(position, target, aim.roll + random.normal(0.03));
      const auto whole_tags = [&](const RigidTransform& pose) {
        return static_cast<int>(visible_tags(building, camera.truth, pose).size());
      };
      if (Random(seed, "cut " + station.image).uniform() < options.cut_tags) {
        const RigidTransform turned = cutting_a_tag(building, camera.truth, station.camera_from_building);
        if (whole_tags(turned) >= options.required_tags) station.camera_from_building = turned;
      }
      const int seen = whole_tags(station.camera_from_building);
      if (seen < options.required_tags) {
        throw std::invalid_argument("image " + station.image + " would see " + std::to_string(seen) +
                                    " whole tags, every image has to see " + std::to_string(options.required_tags) +
                                    "; stand farther off (distance is " + std::to_string(distance) +
                                    " m) or use a wider lens");
      }
      stations.push_back(std::move(station));
    }
  }
  return stations;
}

}  // namespace plumbline::simulate

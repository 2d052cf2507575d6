// The simulated camera and the stations it takes its photographs from.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "building.hpp"
#include "geometry/camera.hpp"
#include "obstruction.hpp"

namespace plumbline::simulate {

/// What profiles/*.yaml say of a camera.
struct CameraProfile {
  std::string name, make, model;
  double pixel_pitch = 0;   ///< [m]
  double focal_length = 0;  ///< [m]
  BrownCamera nominal;      ///< true values before the seed's variation; pixels
  std::array<double, BrownCamera::parameter_count> calibration_sigmas{};  ///< in the order and units of BrownCamera
  double blur = 0;        ///< standard deviation of the point spread function [px]
  double vignetting = 0;  ///< share of light lost in the corners
  double read_noise = 0;  ///< [grey levels]
  double shot_noise = 0;  ///< variance per grey level [grey levels]
  int jpeg_quality = 93;
  double distance = 0;  ///< of the stations from the facade [m]
};

/// Names of the profiles in the library.
std::vector<std::string> camera_profile_names();
/// The profile of that name. Throws std::invalid_argument that lists the names if there is none.
CameraProfile camera_profile(const std::string& name);

struct SimulatedCamera {
  CameraProfile profile;
  BrownCamera truth;        ///< what the photographs obey
  BrownCamera calibration;  ///< what processing is given: truth plus an error drawn from profile.calibration_sigmas
};
SimulatedCamera make_camera(const CameraProfile& profile, std::uint64_t seed);

struct CameraNetworkOptions {
  int images_per_floor = 10;  ///< 4 ... 100
  double distance = 0;        ///< from the facade [m]; 0: the profile's
  bool convergent = true;     ///< false: fronto-parallel without roll, which is weak in self-calibration
  double cut_tags = 0;        ///< share of images that are turned until their border cuts through a tag
  int required_tags = 4;      ///< every image has to see so many whole tags
};

struct CameraStation {
  std::string image;  ///< "F02-07.jpg"
  int floor = 0;      ///< storey the camera stands at, from 1
  RigidTransform camera_from_building;
};

/// Stations floor by floor, scattered a little by the seed as a photographer would: convergent in yaw, tilted up and
/// down, every second image rolled by 90 degrees; rolled ones look at a storey boundary and so link two floors. Throws
/// std::invalid_argument if an image would see fewer than `required_tags` whole tags, naming it.
std::vector<CameraStation> plan_camera_stations(const Building& building, const SimulatedCamera& camera,
                                                const CameraNetworkOptions& options, std::uint64_t seed);

/// Pose of a camera at `position` that looks at `target`, turned by `roll` about its axis (positive: image turns
/// counter-clockwise).
RigidTransform look_at(const Eigen::Vector3d& position, const Eigen::Vector3d& target, double roll);

/// A tag that is wholly in an image, with its true corners [px] in the order of tag_corners_in_plate().
struct VisibleTag {
  const Anchor* anchor = nullptr;
  std::array<Eigen::Vector2d, 4> corners;
};
/// k1 of what lies at the depth Z is that of the camera plus slope (1/Z − 1/reference).
struct DepthDistortion {
  double slope = 0;      ///< [m]
  double reference = 1;  ///< [m]
};

/// Tags whose corners lie at least `margin` px inside the image, seen from within 70 degrees of their normal, and that
/// nothing hides.
std::vector<VisibleTag> visible_tags(const Building& building, const BrownCamera& camera,
                                     const RigidTransform& camera_from_building, double margin = 12,
                                     const Obstruction& obstruction = {}, const DepthDistortion& depth_distortion = {});

}  // namespace plumbline::simulate

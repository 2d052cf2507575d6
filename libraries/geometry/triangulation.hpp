// The position of a point from where oriented images see it. Orientations are taken as exact: what their errors do to
// the point only an adjustment tells.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "plumbline/rigid_transform.hpp"

namespace plumbline {

/// A point seen from one image.
struct PointView {
  RigidTransform cam_from_world;
  Eigen::Vector2d normalised;  ///< (x/z, y/z) in the camera frame, free of distortion
};

enum class Triangulation {
  /// Homogeneous linear equations of the projections, by their smallest singular vector, in coordinates centred and
  /// scaled beforehand. Weights an image by the depth of the point in it. Hartley & Zisserman (2004), 12.2.
  dlt,
  /// The point with the least sum of squared distances from the rays, in closed form. Weights far images too much.
  midpoint,
  /// The least sum of squared chords 2 sin(θ/2) between measured and computed directions, by Gauss-Newton from the
  /// midpoint: for directions that are equally accurate this is the least-squares estimate, to θ⁴/12.
  angular
};

struct Triangulated {
  Eigen::Vector3d point;  ///< [m]
  double rms_angle = 0;   ///< between measured and computed directions [rad]
  double parallax = 0;    ///< largest angle between two rays [rad]
};

/// Nothing where the views do not meet in front of all cameras: fewer than two, parallel rays, or a point behind one.
std::optional<Triangulated> triangulate(const std::vector<PointView>& views, Triangulation method);

}  // namespace plumbline

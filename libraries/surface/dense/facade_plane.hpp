// The plane that a facade is measured on: heights above it are what surfaces are made of.
#pragma once

#include <Eigen/Core>
#include <stdexcept>

namespace plumbline::surface {

/// A point is (u, v, h): metres to the right and up as seen from outside, and out of the facade. right × up = out.
struct FacadePlane {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();    ///< in the world [m]
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  ///< columns right, up, out in the world
  Eigen::Vector3d world(const Eigen::Vector3d& uvh) const { return origin + axes * uvh; }
  Eigen::Vector3d local(const Eigen::Vector3d& point) const { return axes.transpose() * (point - origin); }
};

/// The plane through `origin` whose outside is where `out` points to; `up` is the world's z made square to it, or, of a
/// soffit or a roof, the world's y. Throws std::invalid_argument for an `out` that is no direction.
inline FacadePlane facade_plane(const Eigen::Vector3d& origin, const Eigen::Vector3d& out) {
  if (!(out.norm() > 1e-9) || !origin.allFinite())
    throw std::invalid_argument("a facade's plane needs a point and a direction out of it");
  FacadePlane plane;
  plane.origin = origin;
  const Eigen::Vector3d n = out.normalized();
  const Eigen::Vector3d upwards = std::abs(n.z()) < 0.99 ? Eigen::Vector3d::UnitZ() : Eigen::Vector3d::UnitY();
  const Eigen::Vector3d right = upwards.cross(n).normalized();
  plane.axes << right, n.cross(right), n;
  return plane;
}

}  // namespace plumbline::surface

// Rigid transforms between right-handed frames. A variable is named `target_from_source`, so that the frames of a
// product can be read off its factors: world_from_b = world_from_a * a_from_b.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace plumbline {

/// Maps a point of the source frame into the target frame: p_target = rotation · p_source + translation [m].
struct RigidTransform {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();  ///< unit quaternion, target from source
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();  ///< origin of the source frame, in the target frame [m]

  Eigen::Vector3d operator*(const Eigen::Vector3d& point) const { return rotation * point + translation; }

  RigidTransform operator*(const RigidTransform& other) const {
    return {(rotation * other.rotation).normalized(), rotation * other.translation + translation};
  }

  RigidTransform inverse() const {
    const Eigen::Quaterniond back = rotation.conjugate();
    return {back, -(back * translation)};
  }
};

/// The matrix [v]× with [v]× w = v × w.
inline Eigen::Matrix3d skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

/// Unit quaternion of the rotation vector (axis · angle [rad]); exact at zero.
inline Eigen::Quaterniond quaternion_from_rotation_vector(const Eigen::Vector3d& rotation_vector) {
  const double angle = rotation_vector.norm();
  // sin(x/2)/x by its series near zero: the quotient itself loses all digits there.
  const double factor = angle < 1e-6 ? 0.5 - angle * angle / 48.0 : std::sin(0.5 * angle) / angle;
  Eigen::Quaterniond q;
  q.w() = std::cos(0.5 * angle);
  q.vec() = factor * rotation_vector;
  return q.normalized();
}

}  // namespace plumbline

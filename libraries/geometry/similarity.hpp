// Similarity transforms between two sets of corresponding points, such as a free network and its approximate
// coordinates.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

namespace plumbline {

/// p' = scale · rotation · p + translation.
struct SimilarityMotion {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
  double scale = 1;
  Eigen::Vector3d operator*(const Eigen::Vector3d& p) const { return scale * (rotation * p) + translation; }
};

/// The motion that minimises Σ‖to − motion·from‖². Precondition: at least three points that are not on one line, in
/// both. Source: Horn (1987), Closed-form solution of absolute orientation using unit quaternions; its symmetric scale.
SimilarityMotion fit_similarity(const std::vector<Eigen::Vector3d>& from, const std::vector<Eigen::Vector3d>& to,
                                bool with_scale);

/// The proper rotation R that maximises trace(Rᵀ · moment). With moment = Σ w (to − to̅)(from − from̅)ᵀ it is the
/// rotation of the weighted least-squares fit of `from` onto `to`. Source: Kabsch (1976); the reflection is excluded as
/// in Umeyama (1991).
Eigen::Matrix3d rotation_of_moment(const Eigen::Matrix3d& moment);

/// The rotation by the least angle that takes the direction of `from` to that of `to`, neither of them zero. Of
/// opposite directions any axis across them will do; it is the same one every time.
Eigen::Quaterniond shortest_rotation(const Eigen::Vector3d& from, const Eigen::Vector3d& to);

}  // namespace plumbline

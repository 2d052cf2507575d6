// Frames and the transforms between them: any point in any frame that can be reached, with its covariance.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "plumbline/rigid_transform.hpp"

namespace plumbline {

using Matrix7 = Eigen::Matrix<double, 7, 7>;

/// p_to = S · rotation · p_from + translation, S = scale, or diag(scale, scale, 1) with `plan_only`: map projections
/// scale the plan and leave heights alone. With `plan_only` the rotation is about the vertical.
struct FrameLink {
  std::string to, from;
  std::string origin;  ///< where it comes from, in words
  RigidTransform to_from_from;
  double scale = 1;
  bool plan_only = false;
  Matrix7 covariance = Matrix7::Zero();  ///< of (rotation vector in `to` [rad], translation [m], scale)

  Eigen::Vector3d apply(const Eigen::Vector3d& p_from) const;
  Eigen::Vector3d apply_inverse(const Eigen::Vector3d& p_to) const;

  /// Scale and rotation: how a difference of two points in `from` looks in `to`.
  Eigen::Matrix3d linear() const;
};

/// Points and the covariance of all their coordinates together [m²]; an empty covariance is unknown.
struct FramePoints {
  std::vector<Eigen::Vector3d> positions;
  Eigen::MatrixXd covariance;
};

class FrameGraph {
 public:
  void add(FrameLink link) { links_.push_back(std::move(link)); }
  const std::vector<FrameLink>& links() const { return links_; }

  /// All frames, in the order in which they were named first.
  std::vector<std::string> frames() const;

  /// The shortest way: links, and whether each is gone backwards. Throws std::runtime_error that names the frames which
  /// can be reached from `from`, if `to` is none of them.
  struct Step {
    const FrameLink* link;
    bool backwards;
  };
  std::vector<Step> way(const std::string& to, const std::string& from) const;

  /// The points in another frame. What a link is uncertain by, all points have in common: their covariance grows
  /// together, by Σ' = L Σ Lᵀ + B C Bᵀ for each link.
  FramePoints express(const FramePoints& points, const std::string& to, const std::string& from) const;

 private:
  std::vector<FrameLink> links_;
};

}  // namespace plumbline

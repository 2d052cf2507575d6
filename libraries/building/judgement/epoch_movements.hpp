// Whether anchors have moved between two campaigns.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "artifacts/as_built_changes.hpp"

namespace plumbline::judgement {

/// An anchor that was measured in both campaigns: the way from the first place to the second [m], in the frame of the
/// design, and the sum of both covariances (nan: unknown).
struct MeasuredTwice {
  AsBuiltChangeT* change;
  Eigen::Vector3d d;
  Eigen::Matrix3d covariance;
  Eigen::Vector3d place = Eigen::Vector3d::Zero();  ///< of the design [m]
  int column = 0;                                   ///< 0: unknown
};

/// Chi-squared tests of 3 degrees of freedom, at 5 % for all anchors together (Bonferroni). Where more than half have
/// moved, and at least nine tenths of all by the same, that is taken away and told in `out.warnings`. Fills the changes
/// and what `out` says of all.
void test_movements(const std::vector<MeasuredTwice>& pairs, AsBuiltChangesT& out);

}  // namespace plumbline::judgement

// Three points seen from a calibrated camera: M. Persson and K. Nordberg (2018), Lambda Twist: an accurate fast robust
// perspective three point (P3P) solver, ECCV.
#pragma once

#include <Eigen/Core>
#include <array>

#include "geometry/tag_pose.hpp"

namespace plumbline::pose {

/// Poses cam_from_world in which `points` [m] are seen along `bearings` (unit length, camera frame); up to four.
/// The depths λ hold λᵢ² + λⱼ² − 2 cᵢⱼ λᵢ λⱼ = aᵢⱼ. Two combinations of these are conics without constant term; a third
/// one of their pencil is singular (root of a cubic) and falls apart into two planes through the origin, in each of
/// which a quadratic remains. Depths are then polished with Newton's method. Empty for points on one line.
PoseHypotheses lambda_twist(const std::array<Eigen::Vector3d, 3>& points,
                            const std::array<Eigen::Vector3d, 3>& bearings);

/// On one corner of each of the first three tags of a sample, another one each time; of fewer tags, three corners of
/// what there is.
PoseHypotheses lambda_twist_of_tags(const std::vector<const TagView*>& sample);

}  // namespace plumbline::pose

// What every adjuster of measured targets says of its check points.
#pragma once

#include "photo/block/check_points.hpp"
#include "photo/block/point_block.hpp"
#include "plumbline/node.hpp"

namespace plumbline::block {

/// Warns of each check point that contradicts the block, which then is not to be used: false. A check point whose
/// survey states no standard deviation is judged with that of the block alone.
inline bool tell_check_points(Context& context, const PointBlockResult& result) {
  std::vector<std::string> names;
  std::vector<const ControlResult*> checks;
  for (const ControlResult& control : result.control)
    if (control.check) checks.push_back(&control);
  if (checks.empty()) return true;
  const auto n = 3 * static_cast<Eigen::Index>(checks.size());
  Eigen::VectorXd differences(n);
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(n, n);
  for (const ControlResult* check : checks) {
    const Eigen::Index at = 3 * static_cast<Eigen::Index>(names.size());
    differences.segment<3>(at) = check->residual;
    covariance.block<3, 3>(at, at) = result.point_covariances[check->point];
    if (check->given_sigma.allFinite()) covariance.diagonal().segment<3>(at) += check->given_sigma.cwiseAbs2();
    names.push_back(result.block.points[check->point].name);
  }
  const bool joint = result.check_covariance.rows() == n;
  const CheckJudgement found =
      judge_check_points(names, differences, joint ? result.check_covariance : covariance, joint);
  for (const std::string& sentence : found.words) context.warn(sentence);
  context.metric("check_points", static_cast<double>(names.size()), "1");
  context.metric("check_rmse_3d", std::sqrt(differences.squaredNorm() / static_cast<double>(names.size())), "m");
  return found.holds;
}

}  // namespace plumbline::block

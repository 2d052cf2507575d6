#include "photo/block/check_covariance.hpp"

#include <Eigen/Cholesky>
#include <algorithm>

namespace plumbline::block {
namespace {

/// Coordinates of control that the block follows: neither of check points nor held.
bool is_followed(const BlockControl& control, std::size_t k) {
  return !control.is_check[k] &&
         control.covariance.diagonal().segment<3>(3 * static_cast<Eigen::Index>(k)).minCoeff() > 0;
}

/// What is to be added to factor Q + Σ of check points, `cofactors` between them and the control; rows of `control`'s
/// covariance. Zero where the survey says that they have nothing in common.
Eigen::MatrixXd by_what_is_shared(const Eigen::MatrixXd& cofactors, double factor, const Eigen::MatrixXd& covariance,
                                  const std::vector<Eigen::Index>& checks, const std::vector<Eigen::Index>& known) {
  const auto n = static_cast<Eigen::Index>(checks.size());
  const Eigen::LLT<Eigen::MatrixXd> survey(covariance(known, known));
  if (survey.info() != Eigen::Success) return Eigen::MatrixXd::Zero(n, n);
  const Eigen::MatrixXd solved = survey.solve(covariance(known, checks)), common = cofactors * solved;
  return (factor - 1) * covariance(checks, known) * solved - factor * (common + common.transpose());
}

}  // namespace

void fill_check_covariance(const BlockControl& control, const bundle::Layout& layout,
                           const bundle::Cofactors& cofactors, double factor, PointBlockResult& result) {
  std::vector<int> blocks;
  std::vector<Eigen::Index> rows, unknown, of_unknown, known;
  for (std::size_t k = 0; k < control.points.size(); ++k) {
    if (!control.is_check[k]) continue;
    // Without a standard deviation of the survey, what checks together are off would be held against the block alone.
    const Eigen::Index at = 3 * static_cast<Eigen::Index>(k);
    if (!(control.covariance.diagonal().segment<3>(at).minCoeff() > 0)) return;
    blocks.push_back(layout.block({bundle::Kind::point, control.points[k]}));
    for (int c = 0; c < 3; ++c) {
      if (c < layout.size(blocks.back()))
        unknown.push_back(static_cast<Eigen::Index>(rows.size())), of_unknown.push_back(at + c);
      rows.push_back(at + c);
    }
  }
  if (blocks.empty() || blocks.size() > max_joint_points) return;
  result.check_covariance = control.covariance(rows, rows);
  result.check_covariance(unknown, unknown) += factor * cofactors.joint(blocks);
  for (std::size_t k = 0; k < control.points.size(); ++k)
    if (is_followed(control, k)) {
      blocks.push_back(layout.block({bundle::Kind::point, control.points[k]}));
      for (int c = 0; c < 3; ++c) known.push_back(3 * static_cast<Eigen::Index>(k) + c);
    }
  if (known.empty() || blocks.size() > max_joint_points || control.covariance(known, of_unknown).isZero(0)) return;
  const auto n = static_cast<Eigen::Index>(unknown.size()), m = static_cast<Eigen::Index>(known.size());
  result.check_covariance(unknown, unknown) +=
      by_what_is_shared(cofactors.joint(blocks).topRightCorner(n, m), factor, control.covariance, of_unknown, known);
}

Eigen::Matrix3d covariance_of_difference(const PointBlockResult& result, const BlockControl& control,
                                         const std::vector<std::size_t>& aside, std::size_t k, double unit) {
  const Eigen::Index at = 3 * static_cast<Eigen::Index>(k), point = 3 * static_cast<Eigen::Index>(control.points[k]);
  const Eigen::Matrix3d both =
      result.point_covariances[static_cast<std::size_t>(control.points[k])] + control.covariance.block<3, 3>(at, at);
  std::vector<Eigen::Index> known, in_points;
  for (std::size_t j = 0; j < control.points.size(); ++j)
    for (Eigen::Index c = 0; c < 3; ++c)
      if (is_followed(control, j) && std::find(aside.begin(), aside.end(), j) == aside.end())
        known.push_back(3 * static_cast<Eigen::Index>(j) + c),
            in_points.push_back(3 * static_cast<Eigen::Index>(control.points[j]) + c);
  const std::vector<Eigen::Index> own = {at, at + 1, at + 2}, here = {point, point + 1, point + 2};
  if (result.point_covariance.size() == 0 || known.empty() || control.covariance(known, own).isZero(0)) return both;
  return both +
         by_what_is_shared(result.point_covariance(here, in_points) / unit, unit, control.covariance, own, known);
}

}  // namespace plumbline::block

#include "reliability.hpp"

#include <Eigen/Dense>
#include <cmath>
#include <limits>

#include "adjustment/reliability.hpp"

namespace plumbline::adjust {
namespace {

/// Joint cofactors of one camera's pose and the kept unknowns it depends on; pose first.
Eigen::MatrixXd joint_cofactor(const EliminatedCamera& camera, const Eigen::MatrixXd& kept_cofactor,
                               const Matrix6& pose) {
  const Eigen::Index count = static_cast<Eigen::Index>(camera.columns.size());
  const Eigen::MatrixXd kept = kept_cofactor(camera.columns, camera.columns);
  Eigen::MatrixXd joint(6 + count, 6 + count);
  joint.topLeftCorner<6, 6>() = pose;
  joint.bottomRightCorner(count, count) = kept;
  joint.topRightCorner(6, count) = -camera.inverse * camera.coupling * kept;
  joint.bottomLeftCorner(count, 6) = joint.topRightCorner(6, count).transpose();
  return joint;
}

/// Columns of `rows` as indices into the joint matrix of its camera: 0 … 5 for the pose, then the kept unknowns.
std::vector<int> joint_columns(const ObservationRows& rows, const EliminatedCamera& camera) {
  std::vector<int> columns = {0, 1, 2, 3, 4, 5};
  for (int column : rows.columns) {
    const auto at = std::lower_bound(camera.columns.begin(), camera.columns.end(), column) - camera.columns.begin();
    columns.push_back(6 + static_cast<int>(at));
  }
  return columns;
}

}  // namespace

double minimal_non_centrality() {
  static const double value = adjustment::non_centrality(0.001, 0.8);
  return value;
}

std::vector<Eigen::MatrixXd> residual_cofactors(const LinearBlock& block, const ReducedSystem& reduced,
                                                const LinearSolution& solution) {
  std::vector<Eigen::MatrixXd> joint(reduced.cameras.size());
  for (size_t i = 0; i < joint.size(); ++i)
    joint[i] = joint_cofactor(reduced.cameras[i], solution.kept_cofactor, solution.pose_cofactor[i]);
  std::vector<Eigen::MatrixXd> result;
  result.reserve(block.observations.size());
  for (const auto& rows : block.observations) {
    const Eigen::Index m = rows.misclosure.size();
    Eigen::MatrixXd fitted;
    if (rows.camera < 0) {
      fitted = rows.kept * solution.kept_cofactor(rows.columns, rows.columns) * rows.kept.transpose();
    } else {
      const size_t i = static_cast<size_t>(rows.camera);
      const std::vector<int> columns = joint_columns(rows, reduced.cameras[i]);
      Eigen::MatrixXd design(m, static_cast<Eigen::Index>(columns.size()));
      design << rows.pose, rows.kept;
      fitted = design * joint[i](columns, columns) * design.transpose();
    }
    result.push_back(Eigen::MatrixXd::Identity(m, m) - 0.5 * (fitted + fitted.transpose()));
  }
  return result;
}

std::vector<Reliability> reliability(const Eigen::MatrixXd& square_root, const Eigen::VectorXd& residual,
                                     const Eigen::MatrixXd& cofactor) {
  const Eigen::Index count = residual.size();
  // With L: v = L v', Q_vv P = L Q' L⁻¹, P v = L⁻ᵀ v', P Q_vv P = L⁻ᵀ Q' L⁻¹.
  const Eigen::MatrixXd inverse =
      square_root.triangularView<Eigen::Lower>().solve(Eigen::MatrixXd::Identity(count, count));
  const Eigen::VectorXd own = square_root * residual;
  const Eigen::VectorXd redundancy = (square_root * cofactor * inverse).diagonal();
  const Eigen::VectorXd pushed = inverse.transpose() * residual;
  const Eigen::VectorXd spread = (inverse.transpose() * cofactor * inverse).diagonal();
  std::vector<Reliability> result(static_cast<size_t>(count));
  for (Eigen::Index i = 0; i < count; ++i) {
    const bool checked = redundancy(i) > 1e-9 && spread(i) > 0;
    result[static_cast<size_t>(i)] = {
        own(i), redundancy(i), checked ? pushed(i) / std::sqrt(spread(i)) : 0.0,
        checked ? minimal_non_centrality() / std::sqrt(spread(i)) : std::numeric_limits<double>::infinity()};
  }
  return result;
}

std::vector<GroupStatistics> group_statistics(const LinearBlock& block, const std::vector<Eigen::MatrixXd>& cofactors) {
  std::vector<GroupStatistics> groups(block.groups.size());
  for (size_t g = 0; g < groups.size(); ++g) groups[g].name = block.groups[g];
  for (size_t i = 0; i < block.observations.size(); ++i) {
    GroupStatistics& group = groups[static_cast<size_t>(block.observations[i].group)];
    group.observations += static_cast<int>(block.observations[i].misclosure.size());
    group.weighted_sum_of_squares += block.observations[i].misclosure.squaredNorm();
    group.redundancy += cofactors[i].trace();
  }
  return groups;
}

}  // namespace plumbline::adjust

#include "photo/markers/photograph_shares.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <set>

namespace plumbline::markers {
namespace {

using least_squares::ObservationRows;
using least_squares::PartitionedSystem;

/// The rows' columns with the effects behind them, over `columns`.
Eigen::MatrixXd spread(const ObservationRows& rows, const Eigen::MatrixXd* effects, const std::vector<int>& columns) {
  Eigen::MatrixXd wide = Eigen::MatrixXd::Zero(rows.misclosure.size(), static_cast<Eigen::Index>(columns.size()));
  for (std::size_t k = 0; k < rows.columns.size(); ++k) {
    const auto at = std::lower_bound(columns.begin(), columns.end(), rows.columns[k]) - columns.begin();
    wide.col(at) = rows.kept.col(static_cast<Eigen::Index>(k));
  }
  if (effects && effects->size() > 0) wide.rightCols(effects->cols()) = *effects;
  return wide;
}

}  // namespace

std::vector<PhotographShare> shares_of(const PartitionedSystem& system, const std::vector<Eigen::MatrixXd>& effects) {
  const auto blocks = static_cast<std::size_t>(system.eliminated_count);
  std::vector<std::set<int>> touched(blocks);
  Eigen::Index most_effects = 0;
  for (const Eigen::MatrixXd& effect : effects) most_effects = std::max(most_effects, effect.cols());
  for (const ObservationRows& rows : system.observations)
    if (rows.eliminated >= 0)
      touched[static_cast<std::size_t>(rows.eliminated)].insert(rows.columns.begin(), rows.columns.end());
  std::vector<PhotographShare> shares(blocks);
  std::vector<Eigen::MatrixXd> own(blocks), coupling(blocks);
  std::vector<Eigen::VectorXd> right(blocks);
  for (std::size_t b = 0; b < blocks; ++b) {
    PhotographShare& share = shares[b];
    share.columns.assign(touched[b].begin(), touched[b].end());
    for (Eigen::Index e = 0; e < most_effects; ++e) share.columns.push_back(system.kept_count + static_cast<int>(e));
    const auto n = static_cast<Eigen::Index>(share.columns.size());
    share.score = Eigen::VectorXd::Zero(n), share.information = Eigen::MatrixXd::Zero(n, n);
    own[b] = Eigen::MatrixXd::Zero(system.eliminated_size, system.eliminated_size);
    coupling[b] = Eigen::MatrixXd::Zero(system.eliminated_size, n);
    right[b] = Eigen::VectorXd::Zero(system.eliminated_size);
  }
  for (std::size_t r = 0; r < system.observations.size(); ++r) {
    const ObservationRows& rows = system.observations[r];
    if (rows.eliminated < 0) continue;
    const auto b = static_cast<std::size_t>(rows.eliminated);
    const Eigen::MatrixXd kept = spread(rows, r < effects.size() ? &effects[r] : nullptr, shares[b].columns);
    shares[b].information += kept.transpose() * kept, shares[b].score += kept.transpose() * rows.misclosure;
    own[b] += rows.own.transpose() * rows.own, coupling[b] += rows.own.transpose() * kept;
    right[b] += rows.own.transpose() * rows.misclosure;
  }
  for (std::size_t b = 0; b < blocks; ++b) {
    const Eigen::LDLT<Eigen::MatrixXd> factor(own[b]);
    shares[b].information -= coupling[b].transpose() * factor.solve(coupling[b]);
    shares[b].score -= coupling[b].transpose() * factor.solve(right[b]);
  }
  return shares;
}

Eigen::VectorXd change_without(const PhotographShare& share, const Eigen::MatrixXd& cofactor,
                               const std::vector<int>& wanted) {
  std::vector<int> kept;  // without the effects
  for (const int column : share.columns)
    if (column < cofactor.rows()) kept.push_back(column);
  const auto n = static_cast<Eigen::Index>(kept.size());
  const Eigen::MatrixXd left =
      Eigen::MatrixXd::Identity(n, n) - share.information.topLeftCorner(n, n) * cofactor(kept, kept);
  return -cofactor(wanted, kept) * left.partialPivLu().solve(share.score.head(n));
}

}  // namespace plumbline::markers

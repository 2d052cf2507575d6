// Tests and reliability of a least-squares block, after Baarda.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "linear_block.hpp"

namespace plumbline::adjust {

/// Cofactor matrices of the residuals, one for each entry of block.observations, in whitened rows: Q_vv = I − A Q Aᵀ.
/// Precondition: `solution` has its cofactors.
std::vector<Eigen::MatrixXd> residual_cofactors(const LinearBlock& block, const ReducedSystem& reduced,
                                                const LinearSolution& solution);

/// Quality of one scalar observation. All in the observation's own unit; σ0 = 1.
/// Source: Baarda (1968); Förstner & Wrobel (2016) 4.6; for correlated observations Wang & Chen (1994).
struct Reliability {
  double residual = 0;             ///< adjusted minus observed
  double redundancy_number = 0;    ///< diagonal of Q_vv P: 0 unchecked … 1 fully checked
  double normalised_residual = 0;  ///< w = (P v) / sqrt(P Q_vv P): standard normal without a blunder; 0 if unchecked
  double minimal_detectable_error = 0;  ///< δ0 / sqrt(P Q_vv P); infinite if unchecked
};

/// δ0 = 4.13: a w-test of significance 0.1 % finds an error of the size of the MDB with probability 80 %.
double minimal_non_centrality();

/// Quality of the observations behind whitened rows. `square_root` is L of their covariance Σ = L Lᵀ, rows whitened by
/// L⁻¹; `residual` the whitened residuals, `cofactor` their Q_vv. Residuals below a redundancy number of 1e-9 count as
/// unchecked.
std::vector<Reliability> reliability(const Eigen::MatrixXd& square_root, const Eigen::VectorXd& residual,
                                     const Eigen::MatrixXd& cofactor);

/// Sums of one group of observations. The variance factor is Σv²/Σr of the group: Förstner's estimate of its variance
/// component.
struct GroupStatistics {
  std::string name;
  int observations = 0;
  double weighted_sum_of_squares = 0;
  double redundancy = 0;
  double variance_factor() const { return redundancy > 1e-9 ? weighted_sum_of_squares / redundancy : 0; }
};

/// One entry for each of block.groups. Precondition: misclosures are those after the adjustment.
std::vector<GroupStatistics> group_statistics(const LinearBlock& block, const std::vector<Eigen::MatrixXd>& cofactors);

}  // namespace plumbline::adjust

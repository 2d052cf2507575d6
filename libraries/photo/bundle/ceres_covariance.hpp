// Covariances by Ceres, from its own factorisation of the same observations: what ours are held against.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "photo/bundle/problem.hpp"

namespace plumbline::bundle {

/// Cofactors of each of some blocks (Layout's numbers; in the steps that Layout describes) at `state`, by
/// ceres::Covariance with SPARSE_QR, one thread. Precondition: the blocks have unknowns. Throws std::runtime_error if
/// Ceres finds the block rank deficient, which a block without a datum is.
std::vector<Eigen::MatrixXd> covariances_by_ceres(const Problem& problem, const State& state,
                                                  const std::vector<int>& blocks);

}  // namespace plumbline::bundle

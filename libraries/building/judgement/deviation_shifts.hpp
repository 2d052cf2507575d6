// What the deviations of all anchors, and of single floors, facades, columns and print batches, have in common.
#pragma once

#include "building/judgement/deviation.hpp"
#include "building/judgement/difference.hpp"

namespace plumbline::judgement {

/// Block of the i-th point, 3 x 3 or 0 x 0.
inline Eigen::MatrixXd block_of(const judgement::BlockCovariance& covariance, std::size_t i) {
  if (covariance.size() == 0) return {};
  return covariance.block(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(i));
}

/// Fills the common shift and those of groups, with a warning for each that is significant. `deviations`: (14) of the
/// measured anchors, as indices into `inputs.anchors` and `out.anchors`, which are judged and have their floors.
void tell_shifts(const DeviationInputs& inputs, const DeviationOptions& options,
                 const judgement::DifferenceSet& deviations, DeviationT& out);

}  // namespace plumbline::judgement

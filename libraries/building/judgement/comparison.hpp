// Statistics of the anchors of one use against one reference.
#pragma once

#include <memory>
#include <vector>

#include "building/judgement/difference.hpp"

namespace plumbline::judgement {

/// Fills every member of the comparison except `use`, `reference`, `evidence`, `evidence_note` and `anchors_listed`.
AccuracyComparisonT compare(DifferenceSet set, const std::vector<AnchorEntry>& table, const Options& options,
                            bool with_drift);

/// One anchor's difference with its verdicts; `covariance` is 3 x 3 or 0 x 0 [m²].
std::unique_ptr<AnchorDifferenceT> anchor_difference(const Eigen::Vector3d& difference,
                                                     const Eigen::MatrixXd& covariance, const Options& options);

/// Chi-square statistic d' S⁺ d with the rank of S as degrees of freedom, directions of less than 0.02 mm left out;
/// null when S [m²] is unknown or zero.
std::unique_ptr<ErrorConsistencyT> consistency(const Eigen::VectorXd& difference, BlockCovariance covariance,
                                               double confidence);

/// RMSE of n zero-mean errors with covariance S: its expectation sqrt(tr S / n) and the range it falls in at the
/// confidence level, from the chi-square distribution with the same first two moments as d'd (Satterthwaite 1946).
struct PredictedRmse {
  double value, lower, upper;
};
PredictedRmse predicted_rmse(const BlockCovariance& covariance, double n, double confidence);

}  // namespace plumbline::judgement

// What the trials of one alternative say of it: errors with intervals, failures, distance from the bound, consistency.
#pragma once

#include <string>
#include <vector>

#include "statistics/resampling.hpp"

namespace plumbline::statistics {

/// One finished trial; nan where the pipeline does not measure a quantity.
struct Trial {
  double rms;        ///< root mean square error of the trial's points [m]
  double bias;       ///< mean error [m]
  double worst;      ///< largest absolute error [m]
  double predicted;  ///< root mean square error that the result's own covariance predicts [m]
  double bound;      ///< root of the mean Cramér-Rao bound of the same geometry [m]
  double nees;       ///< eᵀ Σ⁻¹ e with the result's own covariance
  double freedom;    ///< its degrees of freedom
};

/// Share of trials that miss a tolerance.
struct FailureRate {
  double tau = 0;          ///< [m]
  std::size_t failed = 0;  ///< trials without a result, or whose worst error is above tau
  double share = 0;
  Interval interval;  ///< Wilson
};

struct TrialSummary {
  std::size_t trials = 0;    ///< asked for and run, finished or not
  std::size_t failures = 0;  ///< of those, without a result
  Estimate rmse;             ///< root of the mean of the trials' squares [m]
  Estimate mean;             ///< of the trials' rms [m]
  Estimate bias;             ///< mean of the trials' mean errors [m]
  Estimate predicted;        ///< root of the mean predicted square [m]
  Estimate efficiency;       ///< bound² / MSE: 1 is the best an unbiased estimator can do
  double nees = 0;           ///< mean per degree of freedom
  Interval nees_band;        ///< where a consistent covariance puts it with the given confidence
  std::vector<FailureRate> failure_rates;
};

/// `failures` are trials that gave no result: they count as failed at every tolerance, and nowhere else.
TrialSummary summarise(const std::vector<Trial>& finished, std::size_t failures, const std::vector<double>& tolerances,
                       const ResamplingOptions& options);

}  // namespace plumbline::statistics

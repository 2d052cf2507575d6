// Intervals and tests by resampling, for statistics of trials that no closed formula covers.
//
// Trials come in strata (scenarios): a resample draws within each stratum as many as it has. A statistic sees the
// trials by their weights, how often each was drawn, so that one function serves the estimate (all 1), the bootstrap
// and the jackknife (one of them 0). The generator is seeded by the caller: same trials, same interval.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "geometry/statistics.hpp"

namespace plumbline::statistics {

using Weights = std::vector<std::vector<double>>;  ///< by stratum, by trial
using Statistic = std::function<double(const Weights&)>;

struct ResamplingOptions {
  double confidence = 0.95;
  int resamples = 2000;
  std::uint64_t seed = 1;
};

struct Estimate {
  double value = 0;
  Interval interval;  ///< both ends nan if there are too few trials for one
};

/// Bias-corrected and accelerated bootstrap interval (Efron 1987, with the acceleration for several samples of Davison
/// and Hinkley 1997, eq. 5.24), two-sided. `trials` is the number of trials in each stratum. A stratum of one trial
/// gives no interval; one in which nothing varies gives an interval of width zero.
Estimate bca(const std::vector<std::size_t>& trials, const Statistic& statistic, const ResamplingOptions& options);

/// The same resamples, several confidence levels: `levels` in, intervals in the same order.
std::vector<Interval> bca_intervals(const std::vector<std::size_t>& trials, const Statistic& statistic,
                                    const std::vector<double>& levels, const ResamplingOptions& options);

/// Two-sided p of the hypothesis that the two members of each pair may be exchanged: `statistic` gets, for each stratum
/// and pair, +1 (as it was) or -1 (exchanged), and must be a difference that changes its sign when all are exchanged.
/// All exchanges where there are at most 4096, else `resamples` drawn ones (Phipson and Smyth 2010: never zero).
double exchange_test(const std::vector<std::size_t>& pairs, const Statistic& statistic,
                     const ResamplingOptions& options);

/// Adjusted p of a family of tests (Holm 1979), in the order given.
std::vector<double> holm(const std::vector<double>& p);

/// Linear interpolation between order statistics (type 7 of Hyndman and Fan 1996). `sorted` ascending, not empty.
double quantile(const std::vector<double>& sorted, double probability);

}  // namespace plumbline::statistics

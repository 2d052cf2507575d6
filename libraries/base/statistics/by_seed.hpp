// Intervals and tests for statistics of repeated trials that no closed formula covers. The unit is the seed.
//
// A seed makes one site with its noise, and all places of a bench (scenarios, values of variables) see that site: their
// errors go up and down together. So a seed is left out, drawn or exchanged as a whole, in all places at once. Drawing
// each place for itself makes the standard deviation of a mean over places too small: 1.65 times on ten scenarios of
// the paper's campaign, with 17 false winners in 30 benches of two exchangeable alternatives.
//
// A statistic sees the trials by the weights of the seeds, so that one function serves the estimate (all 1), the
// jackknife (one of them 0) and the exchange test (+1 and -1). The generator is seeded by the caller: same trials, same
// answer.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "geometry/statistics.hpp"

namespace plumbline::statistics {

using Weights = std::vector<double>;  ///< by seed
using Statistic = std::function<double(const Weights&)>;

struct InferenceOptions {
  double confidence = 0.95;
  int draws = 9999;  ///< of an exchange test that cannot be enumerated; many comparisons need many (see draws_for())
  std::uint64_t seed = 1;
};

struct Estimate {
  double value = 0;
  Interval interval;  ///< both ends nan if there are too few trials for one
};

enum class Scale {
  plain,        ///< differences, means: may have any sign
  logarithmic,  ///< root mean squares and ratios: positive; the interval is symmetric in the logarithm
};

/// Delete-one jackknife over seeds (Tukey 1958) with Student's t of n - 1 degrees of freedom. Of errors of 10 to 60
/// trials it holds what it says (92 to 96 %, tests/unit/statistics/test_coverage.cpp), where the bias-corrected and
/// accelerated bootstrap holds 80 to 93 %: too narrow with few seeds, and misled by a difference with heavy tails.
struct Jackknife {
  double value = 0;
  double standard_error = 0;      ///< nan with fewer than two seeds
  double freedom = 0;             ///< of it: n - 1, unless the caller knows that seeds do not weigh alike
  std::vector<double> influence;  ///< of each seed; zero in the mean, and standard_error² = Σ u² / (n (n - 1))

  Interval interval(double confidence, Scale scale = Scale::plain) const;
  /// Of one seed: standard_error · √n.
  double deviation() const;
};
Jackknife jackknife(std::size_t seeds, const Statistic& statistic);

Estimate estimate(std::size_t seeds, const Statistic& statistic, double confidence, Scale scale);

/// Two-sided p of the hypothesis that the two alternatives may be exchanged in each seed: `statistic` gets +1 (as it
/// was) or -1 (exchanged) for each seed, in all places at once, and must be a difference that changes its sign when all
/// are exchanged. All exchanges where there are at most 4096, else `draws` of them (Phipson and Smyth 2010: never
/// zero).
double exchange_test(std::size_t seeds, const Statistic& statistic, const InferenceOptions& options);

/// Draws with which a test can pass Holm's correction for so many comparisons.
int draws_for(std::size_t comparisons);

/// Seeds with which an exchange test can be below `risk` at all: its least p is 2 / 2ⁿ.
std::size_t seeds_for_risk(double risk);

/// Adjusted p of a family of tests (Holm 1979), in the order given; nan stays out. `shares` of the error probability,
/// one a test and not all alike where some matter more (his section 4); empty: alike.
std::vector<double> holm(const std::vector<double>& p, const std::vector<double>& shares = {});

/// Linear interpolation between order statistics (type 7 of Hyndman and Fan 1996). `sorted` ascending, not empty.
double quantile(const std::vector<double>& sorted, double probability);

/// The number of seeds with which a two-sided test of level `risk` finds a mean difference `difference` with
/// probability `power`, if one seed has the given standard deviation. At least least_seeds; nan if the difference is
/// zero.
double seeds_to_show(double difference, double deviation, double risk, double power);

/// With fewer pairs even the clearest result has a two-sided p above 0.05 (2 / 2^5).
constexpr std::size_t least_seeds = 6;

}  // namespace plumbline::statistics

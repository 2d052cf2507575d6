#include "statistics/resampling.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "geometry/random.hpp"
#include "plumbline/stop.hpp"

namespace plumbline::statistics {

namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

Weights all_ones(const std::vector<std::size_t>& trials) {
  Weights weights;
  for (const std::size_t n : trials) weights.emplace_back(n, 1.0);
  return weights;
}

std::vector<double> bootstrap(const std::vector<std::size_t>& trials, const Statistic& statistic,
                              const ResamplingOptions& options) {
  Random random(options.seed, "bootstrap");
  Weights weights = all_ones(trials);
  std::vector<double> values;
  values.reserve(static_cast<std::size_t>(options.resamples));
  for (int b = 0; b < options.resamples; ++b) {
    stop_point();
    for (std::vector<double>& stratum : weights) {
      std::fill(stratum.begin(), stratum.end(), 0.0);
      for (std::size_t k = 0; k < stratum.size(); ++k)
        stratum[static_cast<std::size_t>(random.uniform() * static_cast<double>(stratum.size()))] += 1;
    }
    values.push_back(statistic(weights));
  }
  return values;
}

/// Zero where nothing varies.
double acceleration(const std::vector<std::size_t>& trials, const Statistic& statistic) {
  Weights weights = all_ones(trials);
  double cubes = 0, squares = 0;
  for (std::size_t s = 0; s < trials.size(); ++s) {
    const auto n = static_cast<double>(trials[s]);
    std::vector<double> left_out;
    for (double& weight : weights[s]) {
      weight = 0;
      left_out.push_back(statistic(weights));
      weight = 1;
    }
    const double mean = std::accumulate(left_out.begin(), left_out.end(), 0.0) / n;
    for (const double value : left_out) {
      const double influence = (n - 1) * (mean - value) / n;
      cubes += influence * influence * influence;
      squares += influence * influence;
    }
  }
  return squares > 0 ? cubes / (6 * squares * std::sqrt(squares)) : 0;
}

Interval bca_interval(const std::vector<double>& sorted, double z0, double a, double confidence) {
  if (sorted.front() == sorted.back()) return {sorted.front(), sorted.front()};
  const auto end = [&](double tail) {
    const double z = z0 + normal_quantile(tail);
    return quantile(sorted, normal_probability(z0 + z / (1 - a * z)));
  };
  const double tail = 0.5 * (1 - confidence);
  return {end(tail), end(1 - tail)};
}

}  // namespace

double quantile(const std::vector<double>& sorted, double probability) {
  const double place = std::clamp(probability, 0.0, 1.0) * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  if (below + 1 >= sorted.size()) return sorted.back();
  return sorted[below] + (place - static_cast<double>(below)) * (sorted[below + 1] - sorted[below]);
}

std::vector<Interval> bca_intervals(const std::vector<std::size_t>& trials, const Statistic& statistic,
                                    const std::vector<double>& levels, const ResamplingOptions& options) {
  const bool too_few = trials.empty() || std::any_of(trials.begin(), trials.end(), [](std::size_t n) { return n < 2; });
  if (too_few) return std::vector<Interval>(levels.size(), Interval{kNan, kNan});
  const double estimate = statistic(all_ones(trials));
  std::vector<double> values = bootstrap(trials, statistic, options);
  values.erase(std::remove_if(values.begin(), values.end(), [](double v) { return !std::isfinite(v); }), values.end());
  if (values.size() < static_cast<std::size_t>(options.resamples) / 2 || !std::isfinite(estimate))
    return std::vector<Interval>(levels.size(), Interval{kNan, kNan});
  std::sort(values.begin(), values.end());
  const auto below = std::lower_bound(values.begin(), values.end(), estimate) - values.begin();
  const auto up_to = std::upper_bound(values.begin(), values.end(), estimate) - values.begin();
  const auto n = static_cast<double>(values.size());
  // The estimate may lie outside of all resamples; half a resample beyond them keeps the correction finite.
  const double share = std::clamp(0.5 * static_cast<double>(below + up_to) / n, 0.5 / n, 1 - 0.5 / n);
  const double z0 = normal_quantile(share), a = acceleration(trials, statistic);
  std::vector<Interval> intervals;
  for (const double level : levels) intervals.push_back(bca_interval(values, z0, a, level));
  return intervals;
}

Estimate bca(const std::vector<std::size_t>& trials, const Statistic& statistic, const ResamplingOptions& options) {
  return {statistic(all_ones(trials)), bca_intervals(trials, statistic, {options.confidence}, options).front()};
}

double exchange_test(const std::vector<std::size_t>& pairs, const Statistic& statistic,
                     const ResamplingOptions& options) {
  const std::size_t total = std::accumulate(pairs.begin(), pairs.end(), std::size_t{0});
  if (total == 0) return kNan;
  Weights signs = all_ones(pairs);
  // What rounding leaves between two sums of the same numbers in another order does not make one of them smaller.
  const double observed = std::abs(statistic(signs)) * (1 - 1e-9);
  const bool exact = total <= 12;
  const std::uint64_t rounds = exact ? std::uint64_t{1} << total : static_cast<std::uint64_t>(options.resamples);
  Random random(options.seed, "exchange");
  std::uint64_t as_extreme = 0;
  for (std::uint64_t round = 0; round < rounds; ++round) {
    std::uint64_t bit = 0;
    for (std::vector<double>& stratum : signs)
      for (double& sign : stratum) sign = (exact ? (round >> bit++) & 1 : random.bits() >> 63) ? -1 : 1;
    as_extreme += std::abs(statistic(signs)) >= observed;
  }
  if (exact) return static_cast<double>(as_extreme) / static_cast<double>(rounds);
  return static_cast<double>(as_extreme + 1) / static_cast<double>(rounds + 1);
}

std::vector<double> holm(const std::vector<double>& p) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < p.size(); ++i)
    if (!std::isnan(p[i])) order.push_back(i);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return p[a] < p[b]; });
  std::vector<double> adjusted(p.size(), kNan);
  double largest = 0;
  for (std::size_t k = 0; k < order.size(); ++k) {
    largest = std::max(largest, std::min(1.0, static_cast<double>(order.size() - k) * p[order[k]]));
    adjusted[order[k]] = largest;
  }
  return adjusted;
}

}  // namespace plumbline::statistics

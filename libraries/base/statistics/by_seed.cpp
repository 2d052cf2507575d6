#include "base/statistics/by_seed.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "base/statistics/not_a_number.hpp"
#include "geometry/random.hpp"
#include "plumbline/stop.hpp"

namespace plumbline::statistics {

namespace {

constexpr std::uint64_t kEnough = 400;

}  // namespace

int draws_for(std::size_t comparisons) {
  return static_cast<int>(std::clamp<std::size_t>(400 * comparisons, 9999, 10'000'000));
}

std::size_t seeds_for_risk(double risk) {
  std::size_t seeds = least_seeds;
  while (seeds < 64 && !(std::ldexp(2.0, -static_cast<int>(seeds)) < risk)) ++seeds;
  return seeds;
}

Jackknife jackknife(std::size_t seeds, const Statistic& statistic) {
  Jackknife result;
  Weights weights(seeds, 1.0);
  result.value = statistic(weights);
  result.standard_error = kNan;
  if (seeds < 2) return result;
  for (double& weight : weights) {
    stop_point();
    weight = 0;
    result.influence.push_back(statistic(weights));
    weight = 1;
  }
  const auto n = static_cast<double>(seeds);
  result.freedom = n - 1;
  const double mean = std::accumulate(result.influence.begin(), result.influence.end(), 0.0) / n;
  double squares = 0;
  for (double& value : result.influence) {
    value = (n - 1) * (mean - value);
    squares += value * value;
  }
  result.standard_error = std::sqrt(squares / (n * (n - 1)));
  return result;
}

double Jackknife::deviation() const { return standard_error * std::sqrt(static_cast<double>(influence.size())); }

Interval Jackknife::interval(double confidence, Scale scale) const {
  if (!std::isfinite(standard_error) || !std::isfinite(value)) return {kNan, kNan};
  const double t = student_t_quantile(0.5 * (1 + confidence), freedom);
  if (scale == Scale::plain || !(value > 0)) return {value - t * standard_error, value + t * standard_error};
  const double factor = std::exp(t * standard_error / value);
  return {value / factor, value * factor};
}

Estimate estimate(std::size_t seeds, const Statistic& statistic, double confidence, Scale scale) {
  const Jackknife found = jackknife(seeds, statistic);
  return {found.value, found.interval(confidence, scale)};
}

double exchange_test(std::size_t seeds, const Statistic& statistic, const InferenceOptions& options) {
  if (seeds == 0) return kNan;
  Weights signs(seeds, 1.0);
  // What rounding leaves between two sums of the same numbers in another order does not make one of them smaller.
  const double observed = std::abs(statistic(signs)) * (1 - 1e-9);
  const bool exact = seeds <= 12;
  const std::uint64_t rounds = exact ? std::uint64_t{1} << seeds : static_cast<std::uint64_t>(options.draws);
  Random random(options.seed, "exchange");
  std::uint64_t as_extreme = 0;
  for (std::uint64_t round = 0; round < rounds; ++round) {
    if (round % 256 == 0) stop_point();
    std::uint64_t bit = 0;
    for (double& sign : signs) sign = (exact ? (round >> bit++) & 1 : random.bits() >> 63) ? -1 : 1;
    as_extreme += std::abs(statistic(signs)) >= observed;
    if (!exact && as_extreme == kEnough) return static_cast<double>(kEnough) / static_cast<double>(round + 1);
  }
  if (exact) return static_cast<double>(as_extreme) / static_cast<double>(rounds);
  return static_cast<double>(as_extreme + 1) / static_cast<double>(rounds + 1);
}

std::vector<double> holm(const std::vector<double>& p, const std::vector<double>& shares) {
  const auto share = [&](std::size_t i) { return shares.empty() ? 1.0 : shares[i]; };
  std::vector<std::size_t> order;
  double left = 0;
  for (std::size_t i = 0; i < p.size(); ++i) {
    if (std::isnan(p[i])) continue;
    order.push_back(i);
    left += share(i);
  }
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return p[a] / share(a) < p[b] / share(b); });
  std::vector<double> adjusted(p.size(), kNan);
  double largest = 0;
  for (const std::size_t i : order) {
    largest = std::max(largest, std::min(1.0, left / share(i) * p[i]));
    adjusted[i] = largest;
    left -= share(i);
  }
  return adjusted;
}

double quantile(const std::vector<double>& sorted, double probability) {
  const double place = std::clamp(probability, 0.0, 1.0) * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  if (below + 1 >= sorted.size()) return sorted.back();
  return sorted[below] + (place - static_cast<double>(below)) * (sorted[below + 1] - sorted[below]);
}

double seeds_to_show(double difference, double deviation, double risk, double power) {
  const double ratio = deviation / std::abs(difference);
  if (!std::isfinite(ratio)) return kNan;
  double n = static_cast<double>(least_seeds);
  // The quantiles of Student's t depend on n; from below, the first n that is enough.
  for (int k = 0; k < 60; ++k) {
    const double t = student_t_quantile(1 - 0.5 * risk, n - 1) + student_t_quantile(power, n - 1);
    const double wanted = std::ceil(t * t * ratio * ratio);
    if (wanted <= n) break;
    n = std::max(n + 1, std::floor(0.5 * (n + wanted)));
  }
  return n;
}

}  // namespace plumbline::statistics

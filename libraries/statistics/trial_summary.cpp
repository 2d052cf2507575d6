#include "statistics/trial_summary.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace plumbline::statistics {

namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

using Column = std::vector<double>;

double weighted_mean(const Column& values, const std::vector<double>& weights) {
  double sum = 0, total = 0;
  for (std::size_t i = 0; i < values.size(); ++i) sum += weights[i] * values[i], total += weights[i];
  return sum / total;
}

bool known(const Column& values) {
  return !values.empty() && std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}

/// Nothing if a trial does not know the quantity: a mean over the others would be one of other trials.
Estimate estimate(const Column& values, const ResamplingOptions& options, double (*finish)(double)) {
  if (!known(values)) return {kNan, {kNan, kNan}};
  return bca(
      {values.size()}, [&](const Weights& w) { return finish(weighted_mean(values, w[0])); }, options);
}

double root(double x) { return std::sqrt(x); }
double itself(double x) { return x; }

FailureRate failure_rate(const std::vector<Trial>& finished, std::size_t failures, double tau, double confidence) {
  FailureRate rate{tau, failures, 0, {}};
  for (const Trial& trial : finished) rate.failed += !(trial.worst <= tau);
  const auto all = static_cast<double>(finished.size() + failures);
  rate.share = static_cast<double>(rate.failed) / all;
  rate.interval = wilson_interval(static_cast<double>(rate.failed), all, confidence);
  return rate;
}

}  // namespace

TrialSummary summarise(const std::vector<Trial>& finished, std::size_t failures, const std::vector<double>& tolerances,
                       const ResamplingOptions& options) {
  Column rms, squares, bias, predicted, bounds, worst;
  double nees = 0, freedom = 0;
  for (const Trial& trial : finished) {
    rms.push_back(trial.rms);
    squares.push_back(trial.rms * trial.rms);
    bias.push_back(trial.bias);
    predicted.push_back(trial.predicted * trial.predicted);
    bounds.push_back(trial.bound * trial.bound);
    worst.push_back(trial.worst);
    nees += trial.nees, freedom += trial.freedom;
  }
  TrialSummary summary;
  summary.trials = finished.size() + failures;
  summary.failures = failures;
  summary.rmse = estimate(squares, options, root);
  summary.mean = estimate(rms, options, itself);
  summary.bias = estimate(bias, options, itself);
  summary.predicted = estimate(predicted, options, root);
  summary.efficiency = {kNan, {kNan, kNan}};
  if (known(bounds) && known(squares))
    summary.efficiency = bca(
        {bounds.size()}, [&](const Weights& w) { return weighted_mean(bounds, w[0]) / weighted_mean(squares, w[0]); },
        options);
  summary.nees = nees / freedom;
  summary.nees_band = {kNan, kNan};
  if (freedom > 0 && std::isfinite(freedom)) {
    const double tail = 0.5 * (1 - options.confidence);
    summary.nees_band = {chi_squared_quantile(tail, freedom) / freedom,
                         chi_squared_quantile(1 - tail, freedom) / freedom};
  }
  if (summary.trials > 0 && (finished.empty() || known(worst)))
    for (const double tau : tolerances)
      summary.failure_rates.push_back(failure_rate(finished, failures, tau, options.confidence));
  return summary;
}

}  // namespace plumbline::statistics

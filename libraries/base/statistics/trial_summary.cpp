#include "base/statistics/trial_summary.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <set>

#include "base/statistics/not_a_number.hpp"

namespace plumbline::statistics {

namespace {

constexpr double kRisk = 1e-3;
constexpr double kTenth = 1.1;  ///< a standard deviation that is off by less is as good as can be asked for

constexpr double kFewValues = 2;  ///< a trial, of which one bad value moves NEES

using Column = std::vector<double>;

double weighted_mean(const Column& values, const Weights& weights) {
  double sum = 0, total = 0;
  for (std::size_t i = 0; i < values.size(); ++i) sum += weights[i] * values[i], total += weights[i];
  return sum / total;
}

bool known(const Column& values) {
  return !values.empty() && std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}

/// Nothing if a trial does not know the quantity: a mean over the others would be one of other trials.
Estimate mean_of(const Column& values, double confidence, Scale scale) {
  if (!known(values)) return {kNan, {kNan, kNan}};
  return estimate(
      values.size(), [&](const Weights& w) { return weighted_mean(values, w); }, confidence, scale);
}

Estimate root_mean(const Column& squares, double confidence) {
  if (!known(squares)) return {kNan, {kNan, kNan}};
  return estimate(
      squares.size(), [&](const Weights& w) { return std::sqrt(weighted_mean(squares, w)); }, confidence,
      Scale::logarithmic);
}

/// Of two means of the same trials, to the power.
Estimate ratio_of(const Column& above, const Column& below, double power, double confidence) {
  if (!known(above) || !known(below)) return {kNan, {kNan, kNan}};
  return estimate(
      above.size(),
      [&](const Weights& w) { return std::pow(weighted_mean(above, w) / weighted_mean(below, w), power); }, confidence,
      Scale::logarithmic);
}

FailureRate failure_rate(const std::vector<Trial>& finished, std::size_t failures, double tau, double confidence) {
  FailureRate rate{tau, failures, 0, {}};
  for (const Trial& trial : finished) rate.failed += !(trial.worst <= tau);
  const auto all = static_cast<double>(finished.size() + failures);
  rate.share = static_cast<double>(rate.failed) / all;
  rate.interval = wilson_interval(static_cast<double>(rate.failed), all, confidence);
  return rate;
}

Calibration calibration_of(const std::string& mode, const std::vector<StatedError>& trials, double confidence) {
  Calibration result{mode, {}, 0, 0, {kNan, kNan}, trials.size()};
  Column found, predicted;
  double nees = 0, freedom = 0;
  for (const StatedError& trial : trials) {
    found.push_back(trial.found * trial.found);
    predicted.push_back(trial.predicted * trial.predicted);
    nees += trial.nees, freedom += trial.freedom;
  }
  result.ratio = ratio_of(predicted, found, 0.5, confidence);
  result.strict = ratio_of(predicted, found, 0.5, 1 - kRisk).interval;
  result.nees = nees / freedom;
  result.freedom = freedom;
  if (freedom > 0 && std::isfinite(freedom)) {
    const double tail = 0.5 * (1 - confidence);
    result.nees_band = {chi_squared_quantile(tail, freedom) / freedom,
                        chi_squared_quantile(1 - tail, freedom) / freedom};
  }
  return result;
}

/// Of what is measured, then of each mode that all trials know.
std::vector<Calibration> calibrations(const std::vector<Trial>& finished, double confidence) {
  std::vector<Calibration> list;
  std::vector<StatedError> of_all;
  std::set<std::string> modes;
  for (const Trial& t : finished) {
    of_all.push_back({t.rms, t.predicted, t.nees, t.freedom});
    for (const auto& [mode, stated] : t.modes) modes.insert(mode);
  }
  list.push_back(calibration_of("", of_all, confidence));
  for (const std::string& mode : modes) {
    std::vector<StatedError> of_mode;
    for (const Trial& t : finished)
      if (const auto stated = t.modes.find(mode); stated != t.modes.end()) of_mode.push_back(stated->second);
    if (of_mode.size() == finished.size()) list.push_back(calibration_of(mode, of_mode, confidence));
  }
  list.erase(std::remove_if(list.begin(), list.end(),
                            [](const Calibration& c) { return !std::isfinite(c.ratio.value) && std::isnan(c.nees); }),
             list.end());
  return list;
}

std::string two_digits(double value) {
  const std::string plain = value < 10 ? fmt::format("{:.2g}", value) : fmt::format("{:.0f}", value);
  return plain.find('.') == std::string::npos && value < 10 ? plain + ".0" : plain;
}

}  // namespace

Honesty honesty(const Calibration& calibration) {
  const Interval& ratio = calibration.ratio.interval;
  if (!std::isfinite(ratio.lower) || !std::isfinite(ratio.upper)) return Honesty::unknown;
  const bool known = !calibration.mode.empty() && std::isfinite(calibration.nees) && calibration.freedom > 0 &&
                     calibration.freedom <= kFewValues * static_cast<double>(calibration.trials);
  const double square = calibration.nees * calibration.freedom, tail = 0.5 * kRisk;
  const bool low = known ? square < chi_squared_quantile(tail, calibration.freedom) : calibration.strict.lower > kTenth,
             high = known ? square > chi_squared_quantile(1 - tail, calibration.freedom)
                          : calibration.strict.upper < 1 / kTenth;
  if (ratio.lower > kTenth && low) return Honesty::too_much;
  if (ratio.upper < 1 / kTenth && high) return Honesty::too_little;
  return Honesty::honest;
}

std::string in_words(const Calibration& calibration) {
  const Estimate& ratio = calibration.ratio;
  const std::string in = calibration.mode.empty() ? "" : " in " + calibration.mode;
  const auto range = [](double a, double b) { return two_digits(a) + " to " + two_digits(b); };
  switch (honesty(calibration)) {
    case Honesty::too_much:
      return two_digits(ratio.value) + " times too much" + in + " (" +
             range(ratio.interval.lower, ratio.interval.upper) + ")";
    case Honesty::too_little:
      return two_digits(1 / ratio.value) + " times too little" + in + " (" +
             range(1 / ratio.interval.upper, 1 / ratio.interval.lower) + ")";
    case Honesty::honest:
      return "what is found" + in + " (" + two_digits(ratio.value) + ", " +
             range(ratio.interval.lower, ratio.interval.upper) + ")";
    case Honesty::unknown:
      return "";
  }
  return "";
}

TrialSummary summarise(const std::vector<Trial>& finished, std::size_t failures, const std::vector<double>& tolerances,
                       double confidence) {
  Column rms, squares, bias, predicted, bounds, worst;
  for (const Trial& trial : finished) {
    rms.push_back(trial.rms);
    squares.push_back(trial.rms * trial.rms);
    bias.push_back(trial.bias);
    predicted.push_back(trial.predicted * trial.predicted);
    bounds.push_back(trial.bound * trial.bound);
    worst.push_back(trial.worst);
  }
  TrialSummary summary;
  summary.trials = finished.size() + failures;
  summary.failures = failures;
  summary.rmse = root_mean(squares, confidence);
  summary.mean = mean_of(rms, confidence, Scale::logarithmic);
  summary.bias = mean_of(bias, confidence, Scale::plain);
  summary.predicted = root_mean(predicted, confidence);
  summary.efficiency = ratio_of(bounds, squares, 1, confidence);
  summary.calibration = calibrations(finished, confidence);
  summary.nees = kNan, summary.nees_band = {kNan, kNan};
  for (const Calibration& c : summary.calibration)
    if (c.mode.empty()) summary.nees = c.nees, summary.nees_band = c.nees_band;
  if (summary.trials > 0 && (finished.empty() || known(worst)))
    for (const double tau : tolerances)
      summary.failure_rates.push_back(failure_rate(finished, failures, tau, confidence));
  return summary;
}

}  // namespace plumbline::statistics

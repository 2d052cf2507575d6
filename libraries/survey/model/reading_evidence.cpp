#include "survey/model/reading_evidence.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace plumbline::survey {

namespace {

constexpr double kGon = std::numbers::pi / 200, kDegree = std::numbers::pi / 180;

bool all_are_multiples(const std::vector<double>& values, double step) {
  constexpr double kRounding = 1e-3;  // of a step
  return std::all_of(values.begin(), values.end(), [&](double v) {
    const double steps = v / step;
    return std::abs(steps - std::round(steps)) < kRounding;
  });
}

double coarsest(const std::vector<double>& values, const std::vector<double>& steps) {
  if (values.empty()) return 0;
  for (const double step : steps)
    if (all_are_multiples(values, step)) return step;
  return 0;
}

}  // namespace

bool is_angle_reading(const Observation& o) {
  return o.kind == ObservationKind::direction || o.kind == ObservationKind::zenith_angle ||
         o.kind == ObservationKind::angle || o.kind == ObservationKind::azimuth;
}

Digits digits_of(const std::vector<const Observation*>& readings) {
  static const std::vector<double> angles = {
      1e-1 * kGon,     1e-2 * kGon,    1e-3 * kDegree, 1e-3 * kGon,      kDegree / 3600, 1e-4 * kDegree, 1e-4 * kGon,
      kDegree / 36000, 1e-5 * kDegree, 1e-5 * kGon,    kDegree / 360000, 1e-6 * kDegree, 1e-6 * kGon};
  static const std::vector<double> lengths = {1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6};
  std::vector<double> angle_values, length_values;
  for (const Observation* o : readings) (is_angle_reading(*o) ? angle_values : length_values).push_back(o->value);
  return {coarsest(angle_values, angles), coarsest(length_values, lengths)};
}

double log_chance(const Observation& o, double window) {
  constexpr double kAngle = 0.15e-3 * kGon, kLength = 0.3e-3;  // standard deviations, better than most
  const double sigma = std::numbers::sqrt2 * (is_angle_reading(o) ? kAngle : kLength);
  return std::log(std::max(1e-6, std::erf(window / (std::numbers::sqrt2 * sigma))));
}

double log_choices(int n, int k) { return std::lgamma(n + 1.0) - std::lgamma(k + 1.0) - std::lgamma(n - k + 1.0); }

}  // namespace plumbline::survey

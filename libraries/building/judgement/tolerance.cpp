#include "building/judgement/tolerance.hpp"

#include <cmath>
#include <limits>

#include "geometry/statistics.hpp"

namespace plumbline::judgement {

ToleranceVerdict verdict_of(double d, double u, double tau, double guard_factor) {
  if (!std::isfinite(d)) return ToleranceVerdict::not_measured;
  if (!std::isfinite(u)) return ToleranceVerdict::undecided;
  const double probability = conformance_probability(d, u, tau), enough = normal_probability(guard_factor);
  if (probability >= enough) return ToleranceVerdict::pass;
  return probability <= 1 - enough ? ToleranceVerdict::fail : ToleranceVerdict::undecided;
}

double conformance_probability(double d, double u, double tau) {
  if (!std::isfinite(d) || !std::isfinite(u)) return std::numeric_limits<double>::quiet_NaN();
  if (u <= 0) return std::abs(d) <= tau ? 1.0 : 0.0;
  return normal_probability((tau - d) / u) - normal_probability((-tau - d) / u);
}

std::vector<std::unique_ptr<PassRateT>> pass_rates(const Eigen::VectorXd& heights,
                                                   const std::vector<double>& tolerances, double confidence) {
  std::vector<std::unique_ptr<PassRateT>> rates;
  for (const double tau : tolerances) {
    auto rate = std::make_unique<PassRateT>();
    rate->tolerance = tau;
    rate->evaluated = static_cast<int>(heights.size());
    rate->passed = static_cast<int>((heights.array().abs() <= tau).count());
    if (rate->evaluated > 0) {
      rate->rate = static_cast<double>(rate->passed) / rate->evaluated;
      const Interval wilson = wilson_interval(rate->passed, rate->evaluated, confidence);
      rate->lower = wilson.lower;
      rate->upper = wilson.upper;
      // The lower end of a two-sided interval at 1 - 2a is the one-sided bound at 1 - a.
      rate->exact_lower = clopper_pearson_interval(rate->passed, rate->evaluated, 2 * confidence - 1).lower;
    }
    rates.push_back(std::move(rate));
  }
  return rates;
}

int anchors_needed(double rate, double confidence) {
  return static_cast<int>(std::ceil(std::log(1 - confidence) / std::log(rate)));
}

}  // namespace plumbline::judgement

// Empirical Bayes estimate of Smyth, "Linear models and empirical Bayes methods for assessing differential expression
// in microarray experiments", Statistical Applications in Genetics and Molecular Biology 3 (2004), section 6.2: the
// logarithms of sample variances scatter by trigamma(d / 2) if the true variances are equal; what they scatter more is
// that of the true ones, trigamma(d0 / 2).
#include "building/judgement/moderated_variance.hpp"

#include <boost/math/special_functions/digamma.hpp>
#include <boost/math/special_functions/trigamma.hpp>
#include <cmath>

namespace plumbline::judgement {
namespace {

constexpr double kMostFreedom = 1000;

/// The x with trigamma(x) = value; trigamma falls.
double inverse_trigamma(double value) {
  double low = std::log(1e-3), high = std::log(0.5 * kMostFreedom);
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (boost::math::trigamma(std::exp(middle)) > value ? low : high) = middle;
  }
  return std::exp(0.5 * (low + high));
}

}  // namespace

SampleVariance variance_prior(const std::vector<SampleVariance>& groups) {
  std::vector<double> logs;
  double mean = 0, expected = 0;
  for (const SampleVariance& group : groups) {
    if (!(group.freedom > 0)) continue;
    const double half = 0.5 * group.freedom;
    logs.push_back(std::log(group.variance) - boost::math::digamma(half) + std::log(half));
    mean += logs.back(), expected += boost::math::trigamma(half);
  }
  const double n = static_cast<double>(logs.size());
  if (n < 2) return {};
  mean /= n, expected /= n;
  double scatter = 0;
  for (const double value : logs) scatter += (value - mean) * (value - mean) / (n - 1);
  const double excess = scatter - expected;
  if (!(excess > 0)) return {std::exp(mean), kMostFreedom};
  const double half = inverse_trigamma(excess);
  return {std::exp(mean + boost::math::digamma(half) - std::log(half)), 2 * half};
}

SampleVariance moderated(const SampleVariance& group, const SampleVariance& prior) {
  const double freedom = group.freedom + prior.freedom;
  if (!(freedom > 0)) return {};
  return {(group.freedom * group.variance + prior.freedom * prior.variance) / freedom, freedom};
}

}  // namespace plumbline::judgement

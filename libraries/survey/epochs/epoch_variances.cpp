// Variance ratio of two epochs (Pelzer 1971; Niemeier, Ausgleichungsrechnung, 12.2).
#include <algorithm>
#include <cmath>

#include "geometry/statistics.hpp"
#include "survey/epochs/compare_epochs.hpp"
#include "survey/words/network_words.hpp"

namespace plumbline::survey {

namespace {

/// More than the error `alpha` lets a sound network reach.
bool is_noisy(double variance, int degrees, double alpha) {
  return degrees > 0 && variance * degrees > chi_squared_quantile(1 - alpha, degrees);
}

}  // namespace

VarianceTest test_variances(const EpochVariance& first, const EpochVariance& second, double alpha) {
  VarianceTest test;
  const int f1 = first.degrees_of_freedom, f2 = second.degrees_of_freedom;
  const double s1 = first.sigma0 * first.sigma0, s2 = second.sigma0 * second.sigma0;
  if (f1 <= 0 || f2 <= 0 || !(s1 > 0) || !(s2 > 0)) {
    test.text =
        "the variances of the epochs cannot be tested: one of them has no redundancy; the stated accuracies are "
        "taken as they are";
    return test;
  }
  test.ratio = std::max(s1, s2) / std::min(s1, s2);
  test.critical = s1 > s2 ? fisher_f_quantile(1 - alpha / 2, f1, f2) : fisher_f_quantile(1 - alpha / 2, f2, f1);
  test.differ = test.ratio > test.critical;
  const double pooled = (f1 * s1 + f2 * s2) / (f1 + f2);
  const auto apply = [&](const EpochVariance& epoch, double variance, int degrees, double& factor) {
    if (epoch.applied) return;
    factor = variance;
    test.degrees_of_freedom = test.degrees_of_freedom == 0 ? degrees : std::min(test.degrees_of_freedom, degrees);
  };
  if (test.differ) {
    if (is_noisy(s1, f1, alpha)) apply(first, s1, f1, test.first_factor);
    if (is_noisy(s2, f2, alpha)) apply(second, s2, f2, test.second_factor);
  } else if (is_noisy(pooled, f1 + f2, alpha)) {
    apply(first, pooled, f1 + f2, test.first_factor);
    apply(second, pooled, f1 + f2, test.second_factor);
  }
  const std::string both = "sigma0 " + fixed_digits(first.sigma0, 2) + " and " + fixed_digits(second.sigma0, 2);
  test.text = test.differ
                  ? "the readings of one epoch are better than those of the other (" + both + ", ratio of variances " +
                        fixed_digits(test.ratio, 2) + ", critical " + fixed_digits(test.critical, 2) + ")"
                  : "the readings of both epochs are equally good (" + both + ")";
  if (test.degrees_of_freedom > 0)
    test.text += test.differ ? "; those that are noisier than stated count with what they show of themselves"
                             : "; they are noisier than stated: all tests are with the sigma0 of both, " +
                                   fixed_digits(std::sqrt(pooled), 2);
  return test;
}

}  // namespace plumbline::survey

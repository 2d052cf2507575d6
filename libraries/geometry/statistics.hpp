// Quantiles and probabilities of the distributions that tests of adjustments use, and confidence bounds of proportions.
// Thin names over Boost.Math, so that its slow headers stay in one file. All throw std::domain_error outside their
// domain.
#pragma once

namespace plumbline {

double normal_quantile(double probability);
double normal_probability(double z);  ///< P(Z ≤ z)
double chi_squared_quantile(double probability, double degrees_of_freedom);
double chi_squared_probability(double x, double degrees_of_freedom);  ///< P(X ≤ x)
double student_t_quantile(double probability, double degrees_of_freedom);
double student_t_probability(double t, double degrees_of_freedom);  ///< P(T ≤ t)
double fisher_f_quantile(double probability, double numerator_degrees, double denominator_degrees);
double fisher_f_probability(double f, double numerator_degrees, double denominator_degrees);
double non_central_chi_squared_probability(double x, double degrees_of_freedom, double non_centrality);

/// Two-sided interval of a proportion after `successes` of `trials`.
struct Interval {
  double lower = 0;
  double upper = 0;
};
/// Wilson (1927) score interval.
Interval wilson_interval(double successes, double trials, double confidence);
/// Clopper and Pearson (1934): exact, conservative.
Interval clopper_pearson_interval(double successes, double trials, double confidence);

}  // namespace plumbline

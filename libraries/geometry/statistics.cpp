#include "geometry/statistics.hpp"

#include <algorithm>
#include <boost/math/distributions/beta.hpp>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>
#include <boost/math/distributions/non_central_chi_squared.hpp>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <stdexcept>

namespace plumbline {

namespace bm = boost::math;

double normal_quantile(double probability) { return bm::quantile(bm::normal(), probability); }
double normal_probability(double z) { return bm::cdf(bm::normal(), z); }

double chi_squared_quantile(double probability, double degrees_of_freedom) {
  return bm::quantile(bm::chi_squared(degrees_of_freedom), probability);
}
double chi_squared_probability(double x, double degrees_of_freedom) {
  return bm::cdf(bm::chi_squared(degrees_of_freedom), x);
}

double student_t_quantile(double probability, double degrees_of_freedom) {
  return bm::quantile(bm::students_t(degrees_of_freedom), probability);
}
double student_t_probability(double t, double degrees_of_freedom) {
  return bm::cdf(bm::students_t(degrees_of_freedom), t);
}

double fisher_f_quantile(double probability, double numerator_degrees, double denominator_degrees) {
  return bm::quantile(bm::fisher_f(numerator_degrees, denominator_degrees), probability);
}
double fisher_f_probability(double f, double numerator_degrees, double denominator_degrees) {
  return bm::cdf(bm::fisher_f(numerator_degrees, denominator_degrees), f);
}

double non_central_chi_squared_probability(double x, double degrees_of_freedom, double non_centrality) {
  return bm::cdf(bm::non_central_chi_squared(degrees_of_freedom, non_centrality), x);
}

namespace {
void check_proportion(double successes, double trials, double confidence) {
  if (!(trials > 0 && successes >= 0 && successes <= trials && confidence > 0 && confidence < 1))
    throw std::domain_error("interval of a proportion: needs 0 <= successes <= trials, trials > 0, 0 < confidence < 1");
}
}  // namespace

Interval wilson_interval(double successes, double trials, double confidence) {
  check_proportion(successes, trials, confidence);
  const double z = normal_quantile(0.5 + 0.5 * confidence);
  const double p = successes / trials;
  const double centre = (p + z * z / (2 * trials)) / (1 + z * z / trials);
  const double half = z / (1 + z * z / trials) * std::sqrt(p * (1 - p) / trials + z * z / (4 * trials * trials));
  return {std::max(0.0, centre - half), std::min(1.0, centre + half)};
}

Interval clopper_pearson_interval(double successes, double trials, double confidence) {
  check_proportion(successes, trials, confidence);
  const double tail = 0.5 * (1 - confidence);
  const double failures = trials - successes;
  const double lower = successes == 0 ? 0.0 : bm::quantile(bm::beta_distribution<>(successes, failures + 1), tail);
  const double upper = failures == 0 ? 1.0 : bm::quantile(bm::beta_distribution<>(successes + 1, failures), 1 - tail);
  return {lower, upper};
}

}  // namespace plumbline

#include "loop/gate/inside_probability.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <vector>

namespace plumbline::loop {

double normal_below(double x) {
  constexpr double kFar = 9;  // less than 1e-18 is left there
  if (std::abs(x) > kFar) return x < 0 ? 0 : 1;
  return 0.5 * std::erfc(-x / std::numbers::sqrt2);
}

namespace {

template <std::size_t N>
double polynomial(const double (&c)[N], double x) {
  double sum = c[N - 1];
  for (std::size_t i = N - 1; i-- > 0;) sum = sum * x + c[i];
  return sum;
}

}  // namespace

double normal_quantile(double p) {
  static constexpr double a[] = {3.3871328727963666080e0,  1.3314166789178437745e+2, 1.9715909503065514427e+3,
                                 1.3731693765509461125e+4, 4.5921953931549871457e+4, 6.7265770927008700853e+4,
                                 3.3430575583588128105e+4, 2.5090809287301226727e+3};
  static constexpr double b[] = {1.0,
                                 4.2313330701600911252e+1,
                                 6.8718700749205790830e+2,
                                 5.3941960214247511077e+3,
                                 2.1213794301586595867e+4,
                                 3.9307895800092710610e+4,
                                 2.8729085735721942674e+4,
                                 5.2264952788528545610e+3};
  static constexpr double c[] = {1.42343711074968357734e0,  4.63033784615654529590e0, 5.76949722146069140550e0,
                                 3.64784832476320460504e0,  1.27045825245236838258e0, 2.41780725177450611770e-1,
                                 2.27238449892691845833e-2, 7.74545014278341407640e-4};
  static constexpr double d[] = {1.0,
                                 2.05319162663775882187e0,
                                 1.67638483018380384940e0,
                                 6.89767334985100004550e-1,
                                 1.48103976427480074590e-1,
                                 1.51986665636164571966e-2,
                                 5.47593808499534494600e-4,
                                 1.05075007164441684324e-9};
  static constexpr double e[] = {6.65790464350110377720e0,  5.46378491116411436990e0,  1.78482653991729133580e0,
                                 2.96560571828504891230e-1, 2.65321895265761230930e-2, 1.24266094738807843860e-3,
                                 2.71155556874348757815e-5, 2.01033439929228813265e-7};
  static constexpr double f[] = {1.0,
                                 5.99832206555887937690e-1,
                                 1.36929880922735805310e-1,
                                 1.48753612908506148525e-2,
                                 7.86869131145613259100e-4,
                                 1.84631831751005468180e-5,
                                 1.42151175831644588870e-7,
                                 2.04426310338993978564e-15};
  p = std::clamp(p, 1e-300, 1 - 1e-16);
  const double q = p - 0.5;
  if (std::abs(q) <= 0.425) {
    const double r = 0.180625 - q * q;
    return q * polynomial(a, r) / polynomial(b, r);
  }
  const double r = std::sqrt(-std::log(q < 0 ? p : 1 - p));
  const double x =
      r <= 5 ? polynomial(c, r - 1.6) / polynomial(d, r - 1.6) : polynomial(e, r - 5) / polynomial(f, r - 5);
  return q < 0 ? -x : x;
}

namespace {

constexpr int kPoints = 16, kBlocks = 160, kFewestBlocks = 4;  ///< of the lattice
constexpr double kCloseBounds = 0.001;
/// Of the precision, what those values may be outside with together that are left to themselves.
constexpr double kFarInside = 0.2;
constexpr double kUnbounded = std::numeric_limits<double>::infinity();

double between(double low, double high) {
  // In the upper tail differences of Phi lose their digits: mirrored.
  return low > 0 ? normal_below(-low) - normal_below(-high) : normal_below(high) - normal_below(low);
}

/// Rows of a factor L of the covariance, in groups: those that variable k decides, given the variables before it.
struct Separated {
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> factor;  ///< rows x rank
  Eigen::VectorXd low, high;                                                      ///< less the mean
  std::vector<std::vector<Eigen::Index>> rows;                                    ///< by variable
};

/// Cholesky factor with the narrowest conditional interval as the next pivot; expectations of the variables before
/// stand for them.
Separated separate(const Eigen::VectorXd& mean, Eigen::MatrixXd rest, const Eigen::VectorXd& low,
                   const Eigen::VectorXd& high) {
  const Eigen::Index m = mean.size();
  Separated out;
  out.low = low - mean, out.high = high - mean;
  out.factor = Eigen::MatrixXd::Zero(m, m);
  const Eigen::VectorXd variance = rest.diagonal();
  std::vector<bool> used(static_cast<std::size_t>(m), false);
  Eigen::VectorXd shift = Eigen::VectorXd::Zero(m);
  const auto is_left = [&](Eigen::Index i) { return !used[i] && rest(i, i) > 1e-10 * variance[i] && variance[i] > 0; };
  for (Eigen::Index k = 0;; ++k) {
    Eigen::Index pivot = -1;
    double least = 2;
    for (Eigen::Index i = 0; i < m; ++i) {
      if (!is_left(i)) continue;
      const double s = std::sqrt(rest(i, i));
      const double p = between((out.low[i] - shift[i]) / s, (out.high[i] - shift[i]) / s);
      if (p < least) least = p, pivot = i;
    }
    if (pivot < 0) {
      out.factor.conservativeResize(m, k);
      break;
    }
    const double s = std::sqrt(rest(pivot, pivot));
    const Eigen::VectorXd column = rest.col(pivot) / s;
    for (Eigen::Index i = 0; i < m; ++i) out.factor(i, k) = is_left(i) || i == pivot ? column[i] : 0.0;
    const double a = (out.low[pivot] - shift[pivot]) / s, b = (out.high[pivot] - shift[pivot]) / s;
    const auto density = [](double x) { return std::isfinite(x) ? std::exp(-0.5 * x * x) : 0.0; };
    const double expected =
        least > 1e-12 ? (density(a) - density(b)) / (std::sqrt(2 * std::numbers::pi) * least) : std::clamp(0.0, a, b);
    used[pivot] = true;
    rest -= column * column.transpose();
    shift += expected * out.factor.col(k);
  }
  out.rows.resize(out.factor.cols());
  for (Eigen::Index i = 0; i < m; ++i)
    for (Eigen::Index k = out.factor.cols(); k-- > 0;)
      if (std::abs(out.factor(i, k)) > 1e-7 * std::sqrt(variance[i])) {
        out.rows[k].push_back(i);
        break;
      }
  return out;
}

/// Probability of one point of the lattice: the product of conditional probabilities.
double product_at(const Separated& s, const double* point, double* y) {
  double product = 1;
  const auto rank = static_cast<std::size_t>(s.factor.cols());
  for (std::size_t k = 0; k < rank; ++k) {
    double a = -kUnbounded, b = kUnbounded;
    for (const Eigen::Index i : s.rows[k]) {
      double known = 0;
      const double* row = s.factor.data() + i * s.factor.cols();
      for (std::size_t j = 0; j < k; ++j) known += row[j] * y[j];
      const double slope = row[k];
      double from = (s.low[i] - known) / slope, to = (s.high[i] - known) / slope;
      if (slope < 0) std::swap(from, to);
      a = std::max(a, from), b = std::min(b, to);
    }
    if (!(a < b)) return 0;
    const bool upper = a > 0;  // mirrored there, so that no digits are lost
    const double from = normal_below(upper ? -b : a), to = normal_below(upper ? -a : b);
    product *= to - from;
    if (!(product > 0)) return 0;
    if (k + 1 == rank) break;
    const double x = normal_quantile(from + point[k] * (to - from));
    y[k] = upper ? -x : x;
  }
  return product;
}

double over_lattice(const Separated& s, double precision) {
  static constexpr int kPrimes[] = {2,  3,  5,  7,  11, 13, 17, 19, 23,  29,  31,  37,  41,  43,  47,  53, 59,
                                    61, 67, 71, 73, 79, 83, 89, 97, 101, 103, 107, 109, 113, 127, 131, 137};
  const auto rank = static_cast<std::size_t>(s.factor.cols());
  std::vector<double> root(rank), point(rank), y(rank);
  for (std::size_t k = 0; k < rank; ++k)
    root[k] =
        std::sqrt(static_cast<double>(kPrimes[k % std::size(kPrimes)]) + static_cast<double>(k / std::size(kPrimes)));
  double sum = 0, squares = 0;  // of the means of blocks, which agree sooner the more certain the answer is
  for (int block = 0, i = 1; block < kBlocks; ++block) {
    double mean = 0;
    for (int n = 0; n < kPoints; ++n, ++i) {
      for (std::size_t k = 0; k < rank; ++k) {
        const double u = i * root[k] - std::floor(i * root[k]);
        point[k] = std::abs(2 * u - 1);  // baker's transform
      }
      mean += product_at(s, point.data(), y.data());
      for (double& value : point) value = 1 - value;
      mean += product_at(s, point.data(), y.data());
    }
    mean /= 2 * kPoints;
    sum += mean, squares += mean * mean;
    const int blocks = block + 1;
    const double variance = std::max(0.0, squares / blocks - sum / blocks * (sum / blocks));
    if (blocks >= kFewestBlocks && variance < precision * precision * blocks) return sum / blocks;
  }
  return sum / kBlocks;
}

}  // namespace

double inside_probability(const Eigen::VectorXd& mean, const Eigen::MatrixXd& covariance, const Eigen::VectorXd& low,
                          const Eigen::VectorXd& high, double precision) {
  if (!mean.allFinite() || !covariance.allFinite()) return std::numeric_limits<double>::quiet_NaN();
  double outside = 0, least = 1;
  std::vector<std::pair<double, Eigen::Index>> by_outside;
  for (Eigen::Index i = 0; i < mean.size(); ++i) {
    const double s = std::sqrt(std::max(0.0, covariance(i, i)));
    if (!(s > 0)) {
      if (mean[i] < low[i] || mean[i] > high[i]) return 0;
      continue;
    }
    const double out = normal_below((low[i] - mean[i]) / s) + normal_below((mean[i] - high[i]) / s);
    outside += out, least = std::min(least, 1 - out);
    by_outside.emplace_back(out, i);
  }
  const double at_least = std::max(0.0, 1 - outside);
  if (by_outside.size() < 2 || least - at_least < kCloseBounds) return 0.5 * (least + at_least);
  // Those that are hardly ever outside take between nothing and the sum of their probabilities away.
  std::sort(by_outside.begin(), by_outside.end());
  std::size_t first = 0;
  double beside = 0;
  while (first + 1 < by_outside.size() && beside + by_outside[first].first <= kFarInside * precision)
    beside += by_outside[first++].first;
  std::vector<Eigen::Index> open;
  for (std::size_t i = first; i < by_outside.size(); ++i) open.push_back(by_outside[i].second);
  std::sort(open.begin(), open.end());
  const auto m = static_cast<Eigen::Index>(open.size());
  Eigen::VectorXd mean_of(m), low_of(m), high_of(m);
  Eigen::MatrixXd covariance_of(m, m);
  for (Eigen::Index i = 0; i < m; ++i) {
    const Eigen::Index from = open[i];
    mean_of[i] = mean[from], low_of[i] = low[from], high_of[i] = high[from];
    for (Eigen::Index j = 0; j < m; ++j) covariance_of(i, j) = covariance(from, open[j]);
  }
  return std::clamp(over_lattice(separate(mean_of, covariance_of, low_of, high_of), precision) - 0.5 * beside, 0.0,
                    1.0);
}

}  // namespace plumbline::loop

#include "loop/gate/inside_probability.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <numeric>
#include <vector>

#include "geometry/vectors.hpp"

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

/// AS 241, within 0.425 of the middle.
constexpr double kCentral[] = {3.3871328727963666080e0,  1.3314166789178437745e+2, 1.9715909503065514427e+3,
                               1.3731693765509461125e+4, 4.5921953931549871457e+4, 6.7265770927008700853e+4,
                               3.3430575583588128105e+4, 2.5090809287301226727e+3};
constexpr double kCentralBelow[] = {1.0,
                                    4.2313330701600911252e+1,
                                    6.8718700749205790830e+2,
                                    5.3941960214247511077e+3,
                                    2.1213794301586595867e+4,
                                    3.9307895800092710610e+4,
                                    2.8729085735721942674e+4,
                                    5.2264952788528545610e+3};

}  // namespace

double normal_quantile(double p) {
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
    return q * polynomial(kCentral, r) / polynomial(kCentralBelow, r);
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

/// Points of the lattice that are looked at together: a block, each point with its mirror image.
constexpr int kLanes = 2 * kPoints, kWidth = 4, kVectors = kLanes / kWidth;
typedef std::int64_t L4 __attribute__((vector_size(32)));

/// e^x for -700 <= x <= 0, by the quotient of polynomials of Cephes (Moshier 1989) after x = n log 2 + r.
PLUMBLINE_INLINE V4 exponential(const V4& x) {
  constexpr double kShift = 6755399441055744.0;  // 1.5 * 2^52: the lowest bits of the sum are the nearest whole number
  const V4 shifted = x * 1.4426950408889634073599 + kShift, n = shifted - kShift;
  const V4 r = (x - n * 6.93145751953125e-1) - n * 1.42860682030941723212e-6, rr = r * r;
  const V4 p = r * ((1.26177193074810590878e-4 * rr + 3.02994407707441961300e-2) * rr + 9.99999999999999999910e-1);
  const V4 q =
      ((3.00198505138664455042e-6 * rr + 2.52448340349684104192e-3) * rr + 2.27265548208155028766e-1) * rr + 2.0;
  const L4 power = ((L4)shifted << 52) + 0x3ff0000000000000;
  return (1.0 + 2.0 * p / (q - p)) * (V4)power;
}

/// Phi, after Hart (1968, algorithm 5666; West 2005): to 1e-15.
PLUMBLINE_INLINE V4 normal_below_all(const V4& x) {
  constexpr double kFar = 9;
  V4 z = x < 0.0 ? -x : x;
  z = z > kFar ? V4{} + kFar : z;
  V4 above = 0.0352624965998911 * z + 0.700383064443688, below = 0.0883883476483184 * z + 1.75566716318264;
  for (const double c : {6.37396220353165, 33.912866078383, 112.079291497871, 221.213596169931, 220.206867912376})
    above = above * z + c;
  for (const double c :
       {16.064177579207, 86.7807322029461, 296.564248779674, 637.333633378831, 793.826512519948, 440.413735824752})
    below = below * z + c;
  V4 tail = exponential(-0.5 * z * z) * above / below;
  tail = z < kFar ? tail : V4{};
  return x < 0.0 ? tail : 1.0 - tail;
}

PLUMBLINE_INLINE V4 polynomial_of(const double (&c)[8], const V4& x) {
  V4 sum = V4{} + c[7];
  for (int i = 6; i >= 0; --i) sum = sum * x + c[i];
  return sum;
}

PLUMBLINE_INLINE V4 normal_quantile_all(const V4& p) {
  const V4 q = p - 0.5, r = 0.180625 - q * q;
  V4 x = q * polynomial_of(kCentral, r) / polynomial_of(kCentralBelow, r);
  for (int lane = 0; lane < kWidth; ++lane)
    if (!(std::abs(q[lane]) <= 0.425)) x[lane] = normal_quantile(p[lane]);
  return x;
}

/// A block of the lattice; variables before the present one, lane by lane.
struct Block {
  explicit Block(std::size_t rank) : point(rank * kLanes), y(rank * kLanes) {}
  std::vector<double> point, y;
  double product[kLanes];
};

/// Narrows [a, b] of all lanes to what row i leaves to variable k.
PLUMBLINE_INLINE void narrow(const Separated& s, Eigen::Index i, std::size_t k, const double* y, V4 (&a)[kVectors],
                             V4 (&b)[kVectors]) {
  V4 known[kVectors] = {};
  const double* row = s.factor.data() + i * s.factor.cols();
  for (std::size_t j = 0; j < k; ++j)
    for (int v = 0; v < kVectors; ++v) known[v] += row[j] * load<V4>(y + j * kLanes + v * kWidth);
  const double low = row[k] < 0 ? s.high[i] : s.low[i], high = row[k] < 0 ? s.low[i] : s.high[i];
  for (int v = 0; v < kVectors; ++v) {
    const V4 from = (low - known[v]) / row[k], to = (high - known[v]) / row[k];
    a[v] = from > a[v] ? from : a[v];
    b[v] = to < b[v] ? to : b[v];
  }
}

/// Probability of each point of a block: the product of conditional probabilities.
PLUMBLINE_CLONES
void multiply_intervals(const Separated& s, Block& block) {
  V4 product[kVectors];
  for (V4& one : product) one = V4{} + 1.0;
  const auto rank = static_cast<std::size_t>(s.factor.cols());
  for (std::size_t k = 0; k < rank; ++k) {
    V4 a[kVectors], b[kVectors];
    for (V4& one : a) one = V4{} - kUnbounded;
    for (V4& one : b) one = V4{} + kUnbounded;
    for (const Eigen::Index i : s.rows[k]) narrow(s, i, k, block.y.data(), a, b);
    for (int v = 0; v < kVectors; ++v) {
      const L4 upper = a[v] > 0.0;  // mirrored there, so that no digits are lost
      const V4 from = normal_below_all(upper ? -b[v] : a[v]), to = normal_below_all(upper ? -a[v] : b[v]);
      const V4 all = product[v] * (to - from);
      product[v] = (a[v] < b[v]) & (all > 0.0) ? all : V4{};
      if (k + 1 == rank) continue;
      const std::size_t at = k * kLanes + static_cast<std::size_t>(v) * kWidth;
      const V4 x = normal_quantile_all(from + load<V4>(&block.point[at]) * (to - from));
      store(&block.y[at], upper ? -x : x);
    }
  }
  for (int v = 0; v < kVectors; ++v) store(block.product + v * kWidth, product[v]);
}

double over_lattice(const Separated& s, double precision) {
  static constexpr int kPrimes[] = {2,  3,  5,  7,  11, 13, 17, 19, 23,  29,  31,  37,  41,  43,  47,  53, 59,
                                    61, 67, 71, 73, 79, 83, 89, 97, 101, 103, 107, 109, 113, 127, 131, 137};
  const auto rank = static_cast<std::size_t>(s.factor.cols());
  std::vector<double> root(rank);
  for (std::size_t k = 0; k < rank; ++k)
    root[k] =
        std::sqrt(static_cast<double>(kPrimes[k % std::size(kPrimes)]) + static_cast<double>(k / std::size(kPrimes)));
  Block lanes(rank);
  double sum = 0, squares = 0;  // of the means of blocks, which agree sooner the more certain the answer is
  for (int block = 0, i = 1; block < kBlocks; ++block) {
    for (int n = 0; n < kPoints; ++n, ++i)
      for (std::size_t k = 0; k < rank; ++k) {
        const double u = i * root[k] - std::floor(i * root[k]), baked = std::abs(2 * u - 1);  // baker's transform
        lanes.point[k * kLanes + 2 * n] = baked, lanes.point[k * kLanes + 2 * n + 1] = 1 - baked;
      }
    multiply_intervals(s, lanes);
    double mean = 0;
    for (const double product : lanes.product) mean += product;
    mean /= kLanes;
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

#include "building/judgement/conformance.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <mutex>

#include "geometry/linear_algebra/decompositions.hpp"
#include "geometry/random.hpp"
#include "geometry/statistics.hpp"

namespace plumbline::judgement {
namespace {

constexpr double inf = std::numeric_limits<double>::infinity();
constexpr int kSamples = 4096;
/// Rounding of a limit and of a value that equals it [m].
constexpr double kRounding = 1e-12;

/// Halton's sequence in up to three dimensions; beyond, where its bases are too large for so few points, splitmix64.
double uniform(int sample, Eigen::Index dimension, Eigen::Index n) {
  if (n <= 3) {
    const std::array<int, 3> bases = {2, 3, 5};
    const int base = bases[dimension];
    double fraction = 0, digit = 1;
    for (int rest = sample + 1; rest > 0; rest /= base) fraction += (digit /= base) * (rest % base);
    return fraction;
  }
  const std::uint64_t z = mix_bits(0x9e3779b97f4a7c15ULL *
                                   (static_cast<std::uint64_t>(sample) * 4099 + static_cast<std::uint64_t>(dimension)));
  return (static_cast<double>(z >> 11) + 0.5) * 0x1p-53;
}

/// n x 4096 standard normal deviates.
const Eigen::MatrixXd& normal_points(Eigen::Index n) {
  static std::mutex mutex;
  static std::map<Eigen::Index, Eigen::MatrixXd> made;
  const std::lock_guard lock(mutex);
  Eigen::MatrixXd& points = made[n];
  if (points.cols() == 0) {
    points.resize(n, kSamples);
    for (int i = 0; i < kSamples; ++i)
      for (Eigen::Index k = 0; k < n; ++k) points(k, i) = normal_quantile(uniform(i, k, n));
  }
  return points;
}

/// The quantity at every sample, as what it asks of its tolerance: within if that is at most 1. `values`: of its rows.
template <typename Values>
Eigen::RowVectorXd usage(const Limited& quantity, const Values& values) {
  if (values.rows() > 1) return (values.colwise().norm().array() - kRounding) / quantity.above;
  const auto used = [&](double v) {
    const double limit = v < 0 ? quantity.below : quantity.above;
    return std::abs(v) <= kRounding ? 0.0 : limit > 0 ? (std::abs(v) - kRounding) / limit : inf;
  };
  return values.row(0).unaryExpr(used);
}

/// All rows of all quantities at every sample, in one product: one row at a time takes several times as long.
Eigen::MatrixXd values_of(const std::vector<Limited>& quantities, const Eigen::VectorXd& mean,
                          const Eigen::MatrixXd& root) {
  Eigen::Index count = 0, at = 0;
  for (const Limited& quantity : quantities) count += quantity.rows.rows();
  Eigen::MatrixXd rows(count, mean.size());
  for (const Limited& quantity : quantities) {
    rows.middleRows(at, quantity.rows.rows()) = quantity.rows;
    at += quantity.rows.rows();
  }
  const Eigen::MatrixXd of_points = rows * root;
  return (of_points * normal_points(mean.size())).colwise() + Eigen::VectorXd(rows * mean);
}

/// The value that a share of the (unsorted) numbers does not exceed.
double quantile(std::vector<double>& values, double share) {
  const auto at = static_cast<std::size_t>(std::clamp(std::ceil(share * kSamples) - 1, 0.0, kSamples - 1.0));
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(at), values.end());
  return values[at];
}

double of_one(const Limited& quantity, const Eigen::VectorXd& mean, const Eigen::MatrixXd& covariance) {
  const double value = quantity.rows.row(0).dot(mean);
  const double u = std::sqrt(std::max(0.0, (quantity.rows * covariance * quantity.rows.transpose())(0, 0)));
  if (u < kRounding) return value <= quantity.above + kRounding && value >= -quantity.below - kRounding ? 1 : 0;
  return normal_probability((quantity.above - value) / u) - normal_probability((-quantity.below - value) / u);
}

}  // namespace

Conformance conformance(const Eigen::VectorXd& mean, const Eigen::MatrixXd& covariance,
                        const std::vector<Limited>& quantities, double risk, double tau) {
  Conformance result{std::numeric_limits<double>::quiet_NaN(),
                     std::vector<double>(quantities.size(), std::numeric_limits<double>::quiet_NaN()), inf, 0};
  if (quantities.empty() || covariance.size() == 0 || !covariance.allFinite() || !mean.allFinite()) return result;
  const linear_algebra::SymmetricEigen eigen(covariance);
  const Eigen::MatrixXd root = eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0).cwiseSqrt().asDiagonal();
  const Eigen::MatrixXd values = values_of(quantities, mean, root);
  Eigen::Index at = 0;
  Eigen::RowVectorXd worst = Eigen::RowVectorXd::Zero(kSamples), needed = worst;
  for (std::size_t i = 0; i < quantities.size(); ++i) {
    const Limited& quantity = quantities[i];
    const Eigen::RowVectorXd used = usage(quantity, values.middleRows(at, quantity.rows.rows()));
    at += quantity.rows.rows();
    result.of_each[i] = quantity.rows.rows() == 1 ? of_one(quantity, mean, covariance)
                                                  : static_cast<double>((used.array() <= 1).count()) / kSamples;
    worst = worst.cwiseMax(used);
    if (quantity.moves)
      needed = needed.cwiseMax(used * tau);
    else
      needed = (used.array() > 1).select(Eigen::RowVectorXd::Constant(kSamples, inf), needed);
  }
  result.probability = quantities.size() == 1 && quantities[0].rows.rows() == 1
                           ? result.of_each[0]
                           : static_cast<double>((worst.array() <= 1).count()) / kSamples;
  std::vector<double> taus(needed.data(), needed.data() + needed.size());
  result.tau_pass = quantile(taus, 1 - risk), result.tau_fail = quantile(taus, risk);
  return result;
}

ToleranceVerdict verdict_of(double probability, double risk) {
  if (probability >= 1 - risk) return ToleranceVerdict::pass;
  return probability <= risk ? ToleranceVerdict::fail : ToleranceVerdict::undecided;
}

ToleranceVerdict verdict_at(ToleranceVerdict given, double tau_pass, double tau_fail, double tau, bool doubtful) {
  if (given == ToleranceVerdict::not_measured) return given;
  if (tau >= tau_pass) return doubtful ? ToleranceVerdict::undecided : ToleranceVerdict::pass;
  return tau < tau_fail ? ToleranceVerdict::fail : ToleranceVerdict::undecided;
}

}  // namespace plumbline::judgement

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/linear_algebra/decompositions.hpp"
#include "geometry/median.hpp"
#include "geometry/random.hpp"
#include "photo/markers/camera_evidence.hpp"

namespace plumbline::markers {
namespace {

constexpr int bootstrap_samples = 400;

/// Ratio of standard deviations of resampled photographs to `sigma`, median over the parameters.
double bootstrap_ratio(const CameraEvidence& evidence, const Eigen::VectorXd& sigma) {
  const auto p = static_cast<Eigen::Index>(evidence.parameters.size());
  const std::size_t n = evidence.score.size();
  const Eigen::MatrixXd total = evidence.formal.inverse();
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(p, p);
  for (const Eigen::MatrixXd& one : evidence.information) sum += one.topLeftCorner(p, p);
  Random random(1, "photographs");
  std::vector<std::vector<double>> samples(static_cast<std::size_t>(p));
  for (int b = 0; b < bootstrap_samples; ++b) {
    // What the points and the board take of the information is the same in every sample.
    Eigen::MatrixXd normal = total - sum;
    Eigen::VectorXd right = Eigen::VectorXd::Zero(p);
    for (std::size_t k = 0; k < n; ++k) {
      const std::size_t drawn = std::min(n - 1, static_cast<std::size_t>(random.uniform() * static_cast<double>(n)));
      normal += evidence.information[drawn].topLeftCorner(p, p), right += evidence.score[drawn].head(p);
    }
    const Eigen::LDLT<Eigen::MatrixXd> factor(normal);
    if (!factor.isPositive()) continue;
    const Eigen::VectorXd moved = factor.solve(right);
    for (Eigen::Index k = 0; k < p; ++k) samples[k].push_back(moved(k));
  }
  // By the quartiles: a sample of few distinct photographs determines hardly anything.
  std::vector<double> ratios;
  for (Eigen::Index k = 0; k < p; ++k) {
    auto& values = samples[k];
    if (values.size() < 50 || !(sigma(k) > 0)) continue;
    std::sort(values.begin(), values.end());
    const double spread = values[3 * values.size() / 4] - values[values.size() / 4];
    ratios.push_back(spread / 1.349 / sigma(k));
  }
  return ratios.empty() ? std::nan("") : upper_median(ratios);
}

/// Each photograph's influence on the parameters, a row each, centred, in units of the formal covariance: of a sound
/// model their products add up to the unit matrix.
Eigen::MatrixXd influences_of(const CameraEvidence& evidence, const Eigen::LLT<Eigen::MatrixXd>& root) {
  const auto n = static_cast<Eigen::Index>(evidence.change_without.size()), p = evidence.formal.rows();
  Eigen::MatrixXd influences(n, p);
  for (Eigen::Index k = 0; k < n; ++k) influences.row(k) = root.matrixL().solve(evidence.change_without[k]).transpose();
  influences.rowwise() -= influences.colwise().mean().eval();
  return std::sqrt(1 - 1 / static_cast<double>(n)) * influences;
}

/// Sum of the products of all influences, each pair with its weight, over that of each with itself: in the mean over
/// the parameters, without bias (the influences add up to zero, so wide weights find too little: what they would find
/// of unlike photographs is known). At least 1.
double alike_by(const Eigen::MatrixXd& influences, const Eigen::MatrixXd& weights) {
  const double n = static_cast<double>(influences.rows());
  const Eigen::MatrixXd products = influences * influences.transpose();
  const double total = products.trace(), expected = (weights.trace() - weights.sum() / n) / (n - 1);
  if (!(total > 0) || !(expected > 0)) return 1;
  return std::max(1.0, weights.cwiseProduct(products).sum() / (expected * total));
}

/// Triangles of a quarter of the photographs' width on either side (Bartlett), in the order of the names.
Eigen::MatrixXd neighbours_in_order(Eigen::Index n) {
  const double width = std::max(2.0, 0.25 * static_cast<double>(n));
  Eigen::MatrixXd weights(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j)
      weights(i, j) = std::max(0.0, 1 - std::abs(static_cast<double>(i - j)) / width);
  return weights;
}

/// Where the object lies in the image, how far off, and how it is turned against the line of sight, each in units of
/// its standard deviation: bells of a standard deviation.
Eigen::MatrixXd neighbours_by_place(const std::vector<RigidTransform>& cam_from_object) {
  const auto n = static_cast<Eigen::Index>(cam_from_object.size());
  Eigen::MatrixXd places(n, 5);
  for (Eigen::Index i = 0; i < n; ++i) {
    const RigidTransform& pose = cam_from_object[i];
    const Eigen::Vector3d sight = pose.rotation.conjugate() * Eigen::Vector3d::UnitZ(), &t = pose.translation;
    places.row(i) << sight.x(), sight.y(), t.x() / t.z(), t.y() / t.z(), std::log(std::max(1e-9, t.norm()));
  }
  places.rowwise() -= places.colwise().mean().eval();
  for (Eigen::Index k = 0; k < places.cols(); ++k)
    if (const double norm = places.col(k).norm(); norm > 0) places.col(k) *= std::sqrt(static_cast<double>(n)) / norm;
  Eigen::MatrixXd weights(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j) weights(i, j) = std::exp(-0.5 * (places.row(i) - places.row(j)).squaredNorm());
  return weights;
}

/// What the scatter of the photographs makes of two kinds of errors, and what they are: of the corners' own, and of an
/// effect that every photograph has by itself, of all parameters alike in units of the formal covariance. A photograph
/// that is left out takes its share of the information with it, so the changes are larger than what it does; how much
/// larger is not the same for both.
struct ExpectedScatter {
  Eigen::MatrixXd of_corners, of_effects;  ///< of the changes, whitened; `of_effects` for effects of variance 1
  Eigen::MatrixXd by_effects;              ///< covariance of the parameters by these; by the corners it is 1
};

/// With P the shares of the photographs in the information of the parameters (together 1): without a photograph
/// (1 - P)^-1 times its score changes the parameters. Its score has P - P^2 by the corners and
/// P ((1 - P)^2 + sum of the others' P^2) P by effects.
ExpectedScatter expected_scatter(const CameraEvidence& evidence, const Eigen::MatrixXd& root) {
  const auto p = evidence.formal.rows();
  std::vector<Eigen::MatrixXd> shares;
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(p, p);
  for (const Eigen::MatrixXd& information : evidence.information) {
    shares.push_back(root.transpose() * information.topLeftCorner(p, p) * root);
    sum += shares.back();
  }
  const Eigen::MatrixXd unit = Eigen::MatrixXd::Identity(p, p);
  const Eigen::MatrixXd to_unit = linear_algebra::SymmetricEigen(sum).operatorInverseSqrt();
  ExpectedScatter expected{Eigen::MatrixXd::Zero(p, p), Eigen::MatrixXd::Zero(p, p), Eigen::MatrixXd::Zero(p, p)};
  for (Eigen::MatrixXd& share : shares) {
    share = to_unit * share * to_unit;
    expected.by_effects += share * share;
  }
  for (const Eigen::MatrixXd& share : shares) {
    const linear_algebra::SymmetricEigen axes(share);
    const Eigen::VectorXd own = axes.eigenvalues().cwiseMax(0).cwiseMin(1 - 1e-4);
    const Eigen::MatrixXd& v = axes.eigenvectors();
    const Eigen::VectorXd grown = own.array() / (1 - own.array());
    expected.of_corners += v * grown.asDiagonal() * v.transpose();
    const Eigen::MatrixXd score = v * grown.asDiagonal() * v.transpose();
    const Eigen::MatrixXd others = expected.by_effects - share * share;
    expected.of_effects += score * ((unit - share) * (unit - share) + others) * score;
  }
  return expected;
}

struct Scale {
  Eigen::VectorXd variances;  ///< along the axes of the scatter
  Eigen::MatrixXd axes;
};

/// Covariance of which `scatter` is what `photographs` show: its mean given these, in an inverse Wishart distribution
/// around a multiple of the unit matrix, whose size and narrowness are those that make the scatter most likely. So what
/// is left of nine variances by a few photographs is neither taken at its word nor levelled by the largest of them.
/// Source: Haff (1980), Empirical Bayes estimation of the multivariate normal covariance matrix, Ann. Statist. 8(3).
Scale most_likely(const Eigen::MatrixXd& scatter, int photographs) {
  const auto p = static_cast<double>(scatter.rows()), m = photographs - 1.0;
  const linear_algebra::SymmetricEigen axes(scatter);
  const Eigen::ArrayXd sums = m * axes.eigenvalues().array().max(0);
  const auto log_gamma = [&](double x) {  // multivariate, without what does not depend on x
    double sum = 0;
    for (int k = 0; k < scatter.rows(); ++k) sum += std::lgamma(x - 0.5 * k);
    return sum;
  };
  double best = -std::numeric_limits<double>::infinity(), narrow = 0, size = 0;
  for (int i = 0; i <= 21; ++i) {
    const double nu = p + 1 + 0.5 - std::exp(-1) + std::exp(-1 + i / 3.0);
    const double constant = log_gamma(0.5 * (nu + m)) - log_gamma(0.5 * nu);
    for (int j = -12; j <= 28; ++j) {
      const double psi = std::exp(0.25 * j) * (nu - p - 1);
      const double likelihood = constant + 0.5 * nu * p * std::log(psi) - 0.5 * (nu + m) * (psi + sums).log().sum();
      if (likelihood > best) best = likelihood, narrow = nu, size = psi;
    }
  }
  return {((size + sums) / (narrow + m - p - 1)).matrix(), axes.eigenvectors()};
}

/// Mean ratio of variances of few photographs: that of their scatter, drawn towards what public sets have, as far as so
/// few photographs say little (logarithms; normal and normal).
double level_of_few(const Eigen::MatrixXd& influences) {
  // 18 public sets of 10 to 100 photographs: factors of the standard deviations of 1.1 to 7, their geometric mean 2.4.
  constexpr double usual = 5.6, spread = 0.9;
  const Eigen::MatrixXd scatter = influences.transpose() * influences;
  const double level = scatter.trace() / static_cast<double>(scatter.rows());
  if (!(level > 0) || !std::isfinite(level)) return usual;
  const double directions = scatter.trace() * scatter.trace() / scatter.squaredNorm();  // that make most of it
  const double variance = 2 / (directions * static_cast<double>(influences.rows() - 1));
  const double weight = spread * spread / (spread * spread + variance);
  return std::max(1.0, usual * std::pow(level / usual, weight));
}

}  // namespace

EmpiricalCovariance empirical_covariance(const CameraEvidence& evidence,
                                         const std::vector<RigidTransform>& cam_from_object) {
  EmpiricalCovariance result;
  result.photographs = static_cast<int>(evidence.score.size());
  result.written = result.scatter = evidence.formal;
  const auto p = evidence.formal.rows();
  result.sigma_ratio = Eigen::VectorXd::Ones(p);
  const Eigen::LLT<Eigen::MatrixXd> root(evidence.formal);
  if (p == 0 || result.photographs < 3 || root.info() != Eigen::Success) return result;
  const Eigen::MatrixXd influences = influences_of(evidence, root);
  if (!influences.allFinite()) return result;
  const auto as_of_few = [&] {
    const double level = level_of_few(influences);
    result.written = level * evidence.formal;
    result.factor = std::sqrt(level), result.sigma_ratio.setConstant(result.factor);
    return result;
  };
  if (result.photographs < fewest_to_scatter) return as_of_few();
  const Eigen::MatrixXd lower = root.matrixL(), unit = Eigen::MatrixXd::Identity(p, p);
  Eigen::MatrixXd found = Eigen::MatrixXd::Zero(p, p);
  for (const Eigen::VectorXd& change : evidence.change_without) {
    const Eigen::VectorXd white = root.matrixL().solve(change);
    found += white * white.transpose();
  }
  const ExpectedScatter expected = expected_scatter(evidence, lower);
  const double effects =
      std::max(0.0, (found - expected.of_corners).trace() / std::max(1e-12, expected.of_effects.trace()));
  const Eigen::MatrixXd to_unit =
      linear_algebra::SymmetricEigen(expected.of_corners + effects * expected.of_effects).operatorInverseSqrt();
  const Eigen::MatrixXd from_unit = linear_algebra::SymmetricEigen(unit + effects * expected.by_effects).operatorSqrt();
  const Eigen::MatrixXd even = to_unit * found * to_unit;
  if (!even.allFinite()) return as_of_few();  // the photographs alone leave a direction open
  const Scale scale = most_likely(even, result.photographs);
  result.by_order = std::sqrt(alike_by(influences, neighbours_in_order(influences.rows())));
  if (cam_from_object.size() == evidence.score.size())
    result.by_place = std::sqrt(alike_by(influences, neighbours_by_place(cam_from_object)));
  const double alike = std::pow(std::max(result.by_order, result.by_place), 2);
  const Eigen::MatrixXd turned = from_unit * scale.axes;
  const linear_algebra::SymmetricEigen axes(
      Eigen::MatrixXd(alike * turned * scale.variances.asDiagonal() * turned.transpose()));
  const Eigen::MatrixXd larger =
      axes.eigenvectors() * axes.eigenvalues().cwiseMax(1).asDiagonal() * axes.eigenvectors().transpose();
  result.judged = true;
  result.scatter = alike * lower * from_unit * even * from_unit * lower.transpose();
  result.written = lower * larger * lower.transpose();
  result.written = (0.5 * (result.written + result.written.transpose())).eval();
  result.factor = std::sqrt(larger.trace() / static_cast<double>(p));
  result.sigma_ratio = (result.written.diagonal().array() / evidence.formal.diagonal().array()).sqrt();
  result.bootstrap_ratio = bootstrap_ratio(evidence, (result.scatter.diagonal() / alike).cwiseMax(0).cwiseSqrt());
  return result;
}

}  // namespace plumbline::markers

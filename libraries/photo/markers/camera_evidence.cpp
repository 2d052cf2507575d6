#include "photo/markers/camera_evidence.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>

#include "geometry/median.hpp"
#include "geometry/random.hpp"

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
    for (Eigen::Index k = 0; k < p; ++k) samples[static_cast<std::size_t>(k)].push_back(moved(k));
  }
  // By the quartiles: a sample of few distinct photographs determines hardly anything.
  std::vector<double> ratios;
  for (Eigen::Index k = 0; k < p; ++k) {
    auto& values = samples[static_cast<std::size_t>(k)];
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
  for (Eigen::Index k = 0; k < n; ++k)
    influences.row(k) = root.matrixL().solve(evidence.change_without[static_cast<std::size_t>(k)]).transpose();
  influences.rowwise() -= influences.colwise().mean().eval();
  return std::sqrt(1 - 1 / static_cast<double>(n)) * influences;
}

/// Sum of the products of all influences, each pair with its weight, over that of each with itself: in the mean over
/// the parameters, without bias (the influences add up to zero, so wide weights find too little: what they would find
/// of unlike photographs is known), and less one standard deviation of what chance makes of unlike ones. At least 1.
double alike_by(const Eigen::MatrixXd& influences, const Eigen::MatrixXd& weights) {
  const double n = static_cast<double>(influences.rows());
  const Eigen::MatrixXd products = influences * influences.transpose();
  const double total = products.trace(), expected = (weights.trace() - weights.sum() / n) / (n - 1);
  if (!(total > 0) || !(expected > 0)) return 1;
  const double found = weights.cwiseProduct(products).sum() / (expected * total);
  const double off_diagonal = weights.squaredNorm() - weights.diagonal().squaredNorm();
  const double directions = total * total / (influences.transpose() * influences).squaredNorm();
  return std::max(1.0, found - std::sqrt(2 * off_diagonal / directions) / (n * expected));
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
    const RigidTransform& pose = cam_from_object[static_cast<std::size_t>(i)];
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

bool before_by_name(const std::string& a, const std::string& b) {
  const auto digit = [](char c) { return c >= '0' && c <= '9'; };
  std::size_t i = 0, j = 0;
  while (i < a.size() && j < b.size()) {
    if (digit(a[i]) && digit(b[j])) {
      const auto number = [&](const std::string& text, std::size_t& at) {
        while (at < text.size() && text[at] == '0') ++at;
        const std::size_t from = at;
        while (at < text.size() && digit(text[at])) ++at;
        return text.substr(from, at - from);
      };
      const std::string one = number(a, i), two = number(b, j);
      if (one.size() != two.size()) return one.size() < two.size();
      if (one != two) return one < two;
    } else {
      if (a[i] != b[j]) return a[i] < b[j];
      ++i, ++j;
    }
  }
  return a.size() - i < b.size() - j;
}

Eigen::Matrix2d effects_at(const Eigen::Vector2d& pixel, int height) {
  return (pixel.y() / height - 0.5) * Eigen::Matrix2d::Identity();
}

CameraEvidence evidence_of(const std::vector<PhotographShare>& shares, const Eigen::MatrixXd& cofactor, double factor,
                           const std::vector<int>& columns, const std::vector<int>& members,
                           const std::vector<std::string>& paths) {
  CameraEvidence evidence;
  std::vector<int> wanted;
  for (std::size_t k = 0; k < columns.size(); ++k)
    if (columns[k] >= 0) evidence.parameters.push_back(static_cast<int>(k)), wanted.push_back(columns[k]);
  evidence.formal = factor * cofactor(wanted, wanted);
  std::vector<std::size_t> order(members.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return before_by_name(paths[a], paths[b]); });
  const auto kept = static_cast<int>(cofactor.rows());
  for (int e = 0; e < effect_count; ++e) wanted.push_back(kept + e);
  const auto n = static_cast<Eigen::Index>(wanted.size());
  for (const std::size_t k : order) {
    const PhotographShare& share = shares[static_cast<std::size_t>(members[k])];
    evidence.paths.push_back(paths[k]), evidence.members.push_back(members[k]);
    Eigen::VectorXd score = Eigen::VectorXd::Zero(n);
    Eigen::MatrixXd information = Eigen::MatrixXd::Zero(n, n);
    std::vector<Eigen::Index> at;
    for (const int column : wanted) {
      const auto found = std::lower_bound(share.columns.begin(), share.columns.end(), column);
      const bool there = found != share.columns.end() && *found == column;
      at.push_back(there ? found - share.columns.begin() : -1);
    }
    for (Eigen::Index i = 0; i < n; ++i) {
      if (at[static_cast<std::size_t>(i)] < 0) continue;
      score(i) = share.score(at[static_cast<std::size_t>(i)]) / factor;
      for (Eigen::Index j = 0; j < n; ++j)
        if (at[static_cast<std::size_t>(j)] >= 0)
          information(i, j) =
              share.information(at[static_cast<std::size_t>(i)], at[static_cast<std::size_t>(j)]) / factor;
    }
    evidence.score.push_back(score), evidence.information.push_back(information);
    const std::vector<int> parameters(wanted.begin(), wanted.end() - effect_count);
    evidence.change_without.push_back(change_without(share, cofactor, parameters));
  }
  return evidence;
}

EmpiricalCovariance empirical_covariance(const CameraEvidence& evidence,
                                         const std::vector<RigidTransform>& cam_from_object) {
  EmpiricalCovariance result;
  result.photographs = static_cast<int>(evidence.score.size());
  result.written = result.scatter = evidence.formal;
  const auto p = evidence.formal.rows();
  result.sigma_ratio = Eigen::VectorXd::Ones(p);
  const Eigen::LLT<Eigen::MatrixXd> root(evidence.formal);
  if (p == 0 || result.photographs < 3 || root.info() != Eigen::Success) return result;
  const double n = result.photographs;
  const Eigen::MatrixXd influences = influences_of(evidence, root);
  if (!influences.allFinite()) return result;
  if (result.photographs < fewest_to_scatter) {
    const double level = level_of_few(influences);
    result.written = level * evidence.formal;
    result.factor = std::sqrt(level), result.sigma_ratio.setConstant(result.factor);
    return result;
  }
  const Eigen::MatrixXd scatter = influences.transpose() * influences;
  std::vector<Eigen::MatrixXd> products;
  for (Eigen::Index k = 0; k < influences.rows(); ++k)
    products.emplace_back(n * influences.row(k).transpose() * influences.row(k));
  const double level = std::max(0.0, scatter.trace() / static_cast<double>(p));
  const Eigen::MatrixXd target = level * Eigen::MatrixXd::Identity(p, p);
  double noise = 0;
  for (const Eigen::MatrixXd& product : products) noise += (product - scatter).squaredNorm() / (n * n);
  const double apart = (scatter - target).squaredNorm();
  const double shrink = apart > 0 ? std::min(1.0, noise / apart) : 1.0;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> axes(shrink * target + (1 - shrink) * scatter);
  result.by_order = std::sqrt(alike_by(influences, neighbours_in_order(influences.rows())));
  if (cam_from_object.size() == evidence.score.size())
    result.by_place = std::sqrt(alike_by(influences, neighbours_by_place(cam_from_object)));
  const double alike = std::pow(std::max(result.by_order, result.by_place), 2);
  const Eigen::MatrixXd larger =
      axes.eigenvectors() * (alike * axes.eigenvalues()).cwiseMax(1).asDiagonal() * axes.eigenvectors().transpose();
  const Eigen::MatrixXd lower = root.matrixL();
  result.judged = true;
  result.scatter = alike * lower * scatter * lower.transpose();
  result.written = lower * larger * lower.transpose();
  result.written = (0.5 * (result.written + result.written.transpose())).eval();
  result.factor = std::sqrt(larger.trace() / static_cast<double>(p));
  result.sigma_ratio = (result.written.diagonal().array() / evidence.formal.diagonal().array()).sqrt();
  result.bootstrap_ratio = bootstrap_ratio(evidence, (result.scatter.diagonal() / alike).cwiseMax(0).cwiseSqrt());
  return result;
}

Eigen::MatrixXd in_nine(const CameraEvidence& evidence, const Eigen::MatrixXd& of_estimated) {
  Eigen::MatrixXd nine = Eigen::MatrixXd::Zero(BrownCamera::parameter_count, BrownCamera::parameter_count);
  for (std::size_t i = 0; i < evidence.parameters.size(); ++i)
    for (std::size_t j = 0; j < evidence.parameters.size(); ++j)
      nine(evidence.parameters[i], evidence.parameters[j]) =
          of_estimated(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
  return nine;
}

}  // namespace plumbline::markers

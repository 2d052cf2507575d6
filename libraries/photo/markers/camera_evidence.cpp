#include "photo/markers/camera_evidence.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
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

EmpiricalCovariance empirical_covariance(const CameraEvidence& evidence) {
  EmpiricalCovariance result;
  result.photographs = static_cast<int>(evidence.score.size());
  result.written = result.scatter = evidence.formal;
  const auto p = evidence.formal.rows();
  result.sigma_ratio = Eigen::VectorXd::Ones(p);
  const Eigen::LLT<Eigen::MatrixXd> root(evidence.formal);
  if (p == 0 || result.photographs < fewest_to_scatter || root.info() != Eigen::Success) return result;
  const double n = result.photographs;
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(p);
  for (const Eigen::VectorXd& change : evidence.change_without) mean += change / n;
  // In units of the formal covariance: a sound model gives the unit matrix.
  Eigen::MatrixXd scatter = Eigen::MatrixXd::Zero(p, p);
  std::vector<Eigen::MatrixXd> products;
  for (const Eigen::VectorXd& change : evidence.change_without) {
    const Eigen::VectorXd whitened = std::sqrt(n - 1) * root.matrixL().solve(change - mean);
    products.emplace_back(whitened * whitened.transpose());
    scatter += products.back() / n;
  }
  if (!scatter.allFinite()) return result;
  const double level = std::max(0.0, scatter.trace() / static_cast<double>(p));
  const Eigen::MatrixXd target = level * Eigen::MatrixXd::Identity(p, p);
  double noise = 0;
  for (const Eigen::MatrixXd& product : products) noise += (product - scatter).squaredNorm() / (n * n);
  const double apart = (scatter - target).squaredNorm();
  const double shrink = apart > 0 ? std::min(1.0, noise / apart) : 1.0;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> axes(shrink * target + (1 - shrink) * scatter);
  const Eigen::MatrixXd larger =
      axes.eigenvectors() * axes.eigenvalues().cwiseMax(1).asDiagonal() * axes.eigenvectors().transpose();
  const Eigen::MatrixXd lower = root.matrixL();
  result.judged = true;
  result.scatter = lower * scatter * lower.transpose();
  result.written = lower * larger * lower.transpose();
  result.written = (0.5 * (result.written + result.written.transpose())).eval();
  result.factor = std::sqrt(larger.trace() / static_cast<double>(p));
  result.sigma_ratio = (result.written.diagonal().array() / evidence.formal.diagonal().array()).sqrt();
  result.bootstrap_ratio = bootstrap_ratio(evidence, result.scatter.diagonal().cwiseMax(0).cwiseSqrt());
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

#include "control/registration/robust_registration.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "geometry/median.hpp"
#include "geometry/random.hpp"
#include "geometry/similarity.hpp"

namespace plumbline::registration {
namespace {

using Eigen::Index;
constexpr double smallest_weight = 1e-4;  ///< below it a point counts as rejected
constexpr double median_of_chi3 = 1.5382;

double default_threshold(Estimator e) {
  switch (e) {
    case Estimator::huber:
    case Estimator::cauchy:
      return 2.5;
    case Estimator::tukey:
      return 6;
    case Estimator::geman_mcclure:
      return 4;
    default:
      return 4.0333;
  }
}

/// Weight ψ(d)/d of the estimators that reweight.
double weight_of(Estimator e, double d, double c) {
  const double q = d / c;
  switch (e) {
    case Estimator::huber:
      return d <= c ? 1 : c / d;
    case Estimator::cauchy:
      return 1 / (1 + q * q);
    case Estimator::tukey:
      return q >= 1 ? 0 : (1 - q * q) * (1 - q * q);
    case Estimator::geman_mcclure:
      return 1 / ((1 + q * q) * (1 + q * q));
    default:
      return d <= c ? 1 : 0;
  }
}

/// Triples of points: all of them up to 30 points, else 5000 drawn from the seed.
std::vector<std::array<Index, 3>> triples_of(Index n, uint64_t seed) {
  std::vector<std::array<Index, 3>> triples;
  if (n <= 30) {
    for (Index i = 0; i < n; ++i)
      for (Index j = i + 1; j < n; ++j)
        for (Index k = j + 1; k < n; ++k) triples.push_back({i, j, k});
    return triples;
  }
  Random random(seed, "triples");
  const auto next = [&] { return static_cast<Index>(random.bits() % static_cast<uint64_t>(n)); };
  while (triples.size() < 5000) {
    const std::array<Index, 3> t = {next(), next(), next()};
    if (t[0] != t[1] && t[1] != t[2] && t[0] != t[2]) triples.push_back(t);
  }
  return triples;
}

struct Problem {
  Correspondences points;
  /// Covariance of the source in the inner datum of all its control points: residuals know no other, because the fit
  /// takes the rest out of them.
  Eigen::MatrixXd inner;
  RobustOptions options;
  double threshold = 1;
  bool sigma_is_known = true;

  static Correspondences part(const Correspondences& points, const std::vector<int>& chosen) {
    Correspondences c;
    std::vector<Index> rows;
    for (int i : chosen) {
      c.ids.push_back(points.ids[i]);
      for (Index k = 0; k < 3; ++k) rows.push_back(3 * i + k);
    }
    c.source = points.source(Eigen::all, chosen);
    c.target = points.target(Eigen::all, chosen);
    if (points.source_covariance.size() > 0) c.source_covariance = points.source_covariance(rows, rows);
    if (points.target_covariance.size() > 0) c.target_covariance = points.target_covariance(rows, rows);
    return c;
  }

  Eigen::Matrix3d covariance(const Registration& t, Index i) const {
    const Eigen::Matrix3d m = t.scale * t.to_from_from.rotation.toRotationMatrix();
    Eigen::Matrix3d c = Eigen::Matrix3d::Zero();
    if (points.target_covariance.size() > 0) c += points.target_covariance.block<3, 3>(3 * i, 3 * i);
    if (inner.size() > 0) c += m * inner.block<3, 3>(3 * i, 3 * i) * m.transpose();
    // Few points without an error in the target: the figure of one may be without error in a direction.
    c.diagonal().array() += 1e-9 * c.trace();
    return c;
  }

  Eigen::Vector3d residual(const Registration& t, Index i) const {
    return points.target.col(i) -
           (t.scale * (t.to_from_from.rotation * points.source.col(i)) + t.to_from_from.translation);
  }

  /// Whitened distance of every point.
  Eigen::VectorXd distances(const Registration& t) const {
    Eigen::VectorXd d(points.source.cols());
    for (Index i = 0; i < d.size(); ++i) {
      const Eigen::Vector3d r = residual(t, i);
      d(i) = std::sqrt(std::max(0.0, r.dot(covariance(t, i).ldlt().solve(r))));
    }
    return d;
  }

  Registration fit(const Eigen::VectorXd& weights, std::vector<int>& used) const {
    used.clear();
    for (Index i = 0; i < weights.size(); ++i)
      if (weights(i) > smallest_weight) used.push_back(static_cast<int>(i));
    if (used.size() < 3)
      throw DegenerateRegistration("of " + std::to_string(weights.size()) + " points only " +
                                   std::to_string(used.size()) +
                                   " agree with each other: no three that span a triangle are left");
    Options how = options.fit;
    how.weighting = Weighting::covariance;
    how.point_weights = weights(used);
    return register_points(part(points, used), how);
  }

  /// The transform of three points that most others agree with: least truncated sum of squares, or, without a standard
  /// deviation, least median (Rousseeuw 1984).
  Registration best_triple(double& median) const {
    Registration best, candidate;
    double least = std::numeric_limits<double>::infinity();
    std::vector<double> squares(static_cast<size_t>(points.source.cols()));
    for (const auto& t : triples_of(points.source.cols(), options.seed)) {
      std::vector<Eigen::Vector3d> from, to;
      for (Index i : t) from.emplace_back(points.source.col(i)), to.emplace_back(points.target.col(i));
      const Eigen::Vector3d a = from[1] - from[0], b = from[2] - from[0];
      if (!(a.cross(b).norm() > 0.05 * std::max(a.squaredNorm(), b.squaredNorm()))) continue;
      const SimilarityMotion motion = fit_similarity(from, to, options.fit.estimate_scale);
      candidate.to_from_from = {motion.rotation, motion.translation};
      candidate.scale = motion.scale;
      double sum = 0;
      for (Index i = 0; i < points.source.cols(); ++i) {
        double& s = squares[i] = residual(candidate, i).squaredNorm();
        if (sigma_is_known) sum += std::min(s * 3 / covariance(candidate, i).trace(), threshold * threshold);
      }
      const double middle = upper_median(squares), score = sigma_is_known ? sum : middle;
      if (score < least) {
        least = score;
        best = candidate;
        median = std::sqrt(middle);
      }
    }
    if (!std::isfinite(least)) throw DegenerateRegistration("no three points span a triangle");
    return best;
  }
};

Eigen::VectorXd reweight(const Problem& problem, Registration start, std::vector<int>& used, Registration& fit) {
  const Estimator e = problem.options.estimator;
  Eigen::VectorXd weights;
  fit = start;
  for (int iteration = 0; iteration < 200; ++iteration) {
    const Eigen::VectorXd next =
        problem.distances(fit).unaryExpr([&](double d) { return weight_of(e, d, problem.threshold); });
    const bool settled = weights.size() > 0 && (next - weights).cwiseAbs().maxCoeff() < 1e-9;
    weights = next;
    fit = problem.fit(weights, used);
    if (settled) break;
  }
  return weights;
}

/// Graduated non-convexity: from a convex surrogate to the truncated loss, by the schedule of the paper.
Eigen::VectorXd graduate(const Problem& problem, std::vector<int>& used, Registration& fit) {
  const double c2 = problem.threshold * problem.threshold;
  Eigen::VectorXd weights = Eigen::VectorXd::Ones(problem.points.source.cols());
  fit = problem.fit(weights, used);
  double mu = c2 / (2 * problem.distances(fit).cwiseAbs2().maxCoeff() - c2);
  if (!(mu > 0)) return weights;
  for (int iteration = 0; iteration < 500; ++iteration, mu *= 1.4) {
    const Eigen::VectorXd d = problem.distances(fit);
    bool binary = true;
    for (Index i = 0; i < d.size(); ++i) {
      const double s = d(i) * d(i);
      weights(i) = s >= (mu + 1) / mu * c2 ? 0 : s <= mu / (mu + 1) * c2 ? 1 : std::sqrt(c2 * mu * (mu + 1) / s) - mu;
      binary = binary && (weights(i) == 0 || weights(i) == 1);
    }
    // Far from the end all weights are tiny; only their ratios matter.
    const double largest = weights.maxCoeff();
    fit = problem.fit(largest > 0 ? Eigen::VectorXd(weights / largest) : weights, used);
    if (binary) break;
  }
  return weights;
}

/// Equal weights, or one weight a point, as a covariance; so that every estimator has one way of weighting.
void as_covariance(Problem& problem, double sigma) {
  Correspondences& p = problem.points;
  const Index n = p.source.cols();
  if (problem.options.fit.weighting == Weighting::covariance) return;
  Eigen::VectorXd variance = Eigen::VectorXd::Zero(3 * n);
  if (problem.options.fit.weighting == Weighting::equal) variance.setConstant(sigma * sigma);
  if (problem.options.fit.weighting == Weighting::scalar)
    for (const Eigen::MatrixXd* c : {&problem.inner, &p.target_covariance})
      for (Index i = 0; i < n && c->size() > 0; ++i)
        variance.segment<3>(3 * i).array() += c->diagonal().segment<3>(3 * i).mean();
  problem.inner.resize(0, 0);
  p.source_covariance.resize(0, 0);
  p.target_covariance = variance.asDiagonal();
}

/// Residuals of all points over their standard deviations: r = (E − A G) d, where E takes the point itself and G acts
/// on the points used. A motion of the whole source drops out of it, hence any datum will do.
void fill_residuals(const Problem& problem, const Correspondences& stated, RobustRegistration& result) {
  const Index n = stated.source.cols();
  const Eigen::Matrix3d turn = result.fit.scale * result.fit.to_from_from.rotation.toRotationMatrix();
  Eigen::MatrixXd c = Eigen::MatrixXd::Zero(3 * n, 3 * n), through = Eigen::MatrixXd::Identity(3 * n, 3 * n);
  if (stated.target_covariance.size() > 0) c += stated.target_covariance;
  for (Index i = 0; i < 3 * n && stated.source_covariance.size() > 0; i += 3)
    for (Index j = 0; j < 3 * n; j += 3)
      c.block<3, 3>(i, j) += turn * stated.source_covariance.block<3, 3>(i, j) * turn.transpose();
  Eigen::MatrixXd slopes(3 * n, result.fit.unknowns);
  for (Index i = 0; i < n; ++i) slopes.middleRows<3>(3 * i) = point_slopes(result.fit, stated.source.col(i));
  const Eigen::MatrixXd fitted = slopes * result.fit.influence;
  for (size_t k = 0; k < result.used.size(); ++k)
    through.middleCols<3>(3 * result.used[k]) -= fitted.middleCols<3>(3 * static_cast<Index>(k));
  const Eigen::VectorXd variance = (through * c).cwiseProduct(through).rowwise().sum();
  result.residuals.resize(3, n);
  result.w.setZero(3, n);
  for (Index i = 0; i < n; ++i) {
    result.residuals.col(i) = problem.residual(result.fit, i);
    for (Index k = 0; k < 3; ++k)
      if (variance(3 * i + k) > 0) result.w(k, i) = result.residuals(k, i) / std::sqrt(variance(3 * i + k));
  }
}

}  // namespace

RobustRegistration register_robust(const Correspondences& points, const RobustOptions& options) {
  RobustRegistration result;
  Problem problem{
      points, {}, options, options.threshold > 0 ? options.threshold : default_threshold(options.estimator)};
  const Index n = points.source.cols();
  const bool known = points.source_covariance.size() + points.target_covariance.size() > 0;
  if (options.estimator == Estimator::least_squares) {
    result.fit = register_points(points, options.fit);
    result.weights = Eigen::VectorXd::Ones(n);
    for (Index i = 0; i < n; ++i) result.used.push_back(static_cast<int>(i));
    if (!known) as_covariance(problem, std::max(result.fit.sigma0, 1e-12));
    fill_residuals(problem, problem.points, result);
    return result;
  }
  Options figure = options.fit;  // refuses what nothing can be done with, in its words; needs no convergence
  figure.weighting = Weighting::equal;
  register_points(points, figure);
  problem.inner = inner_datum(points.source_covariance, points.source, options.fit.estimate_scale ? 7 : 6);
  double sigma = options.sigma;
  Registration start;
  if (options.fit.weighting == Weighting::equal && !(sigma > 0)) {
    problem.sigma_is_known = false;
    double median = 0;
    start = problem.best_triple(median);
    sigma = std::max(median / median_of_chi3, 1e-9);
    problem.sigma_is_known = true;
  }
  as_covariance(problem, sigma);
  problem.options.fit.weighting = Weighting::covariance;
  double median = 0;
  switch (options.estimator) {
    case Estimator::huber:
    case Estimator::cauchy: {
      start = problem.fit(Eigen::VectorXd::Ones(n), result.used);
      result.weights = reweight(problem, start, result.used, result.fit);
      break;
    }
    case Estimator::truncated:
      result.weights = graduate(problem, result.used, result.fit);
      break;
    default:
      start = problem.best_triple(median);
      result.weights = reweight(problem, start, result.used, result.fit);
      break;
  }
  for (Index i = 0; i < n; ++i)
    if (result.weights(i) <= smallest_weight) result.weights(i) = 0;
  if (known) state_covariance(problem.part(points, result.used), result.fit);
  fill_residuals(problem, known ? points : problem.points, result);
  return result;
}

}  // namespace plumbline::registration

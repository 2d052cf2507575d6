#include "compare_epochs.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "adjustment/reliability.hpp"
#include "geometry/statistics.hpp"

namespace plumbline::survey {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

void check(const Epoch& e, const char* which) {
  const auto n = static_cast<Index>(3 * e.ids.size());
  if (e.coordinates.size() == n && e.covariance.rows() == n && e.covariance.cols() == n) return;
  throw std::runtime_error(std::string("the ") + which + " epoch has " + std::to_string(e.ids.size()) +
                           " points but no covariance of all their coordinates; give the points of survey.adjust");
}

struct Difference {
  std::vector<std::string> ids;
  VectorXd d;           // second minus first
  MatrixXd covariance;  // sum of both
  MatrixXd place;       // 3n: coordinates of the first epoch
};

Difference difference_of(const Epoch& first, const Epoch& second) {
  std::vector<Index> a, b;
  Difference r;
  for (size_t i = 0; i < first.ids.size(); ++i) {
    const auto at = std::find(second.ids.begin(), second.ids.end(), first.ids[i]);
    const auto k = static_cast<Index>(3 * i), l = static_cast<Index>(3 * (at - second.ids.begin()));
    if (at == second.ids.end() || !first.coordinates.segment<3>(k).allFinite() ||
        !second.coordinates.segment<3>(l).allFinite())
      continue;
    r.ids.push_back(first.ids[i]);
    for (Index c = 0; c < 3; ++c) {
      a.push_back(k + c);
      b.push_back(l + c);
    }
  }
  if (r.ids.size() < 3)
    throw std::runtime_error("the two epochs have " + std::to_string(r.ids.size()) +
                             " points in common; a comparison needs at least three");
  r.place = first.coordinates(a);
  r.d = second.coordinates(b) - first.coordinates(a);
  r.covariance = first.covariance(a, a) + second.covariance(b, b);
  return r;
}

/// Translations and rotation about the vertical through the centre: what two free levelled networks may differ by.
MatrixXd motions(const Difference& r) {
  const Index n = r.d.size() / 3;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (Index i = 0; i < n; ++i) centre += r.place.col(0).segment<3>(3 * i) / static_cast<double>(n);
  MatrixXd g = MatrixXd::Zero(3 * n, 4);
  for (Index i = 0; i < n; ++i) {
    const Eigen::Vector3d p = r.place.col(0).segment<3>(3 * i) - centre;
    g.block<3, 3>(3 * i, 0).setIdentity();
    g(3 * i, 3) = p.y();
    g(3 * i + 1, 3) = -p.x();
  }
  return g;
}

/// Difference and covariance with the datum carried by the stable points.
void to_datum(const Difference& r, const std::vector<char>& stable, bool free_datum, VectorXd& d,
              MatrixXd& covariance) {
  d = r.d;
  covariance = r.covariance;
  if (!free_datum) return;
  const MatrixXd g = motions(r);
  MatrixXd c = g;
  for (size_t i = 0; i < stable.size(); ++i)
    if (!stable[i]) c.middleRows(static_cast<Index>(3 * i), 3).setZero();
  const MatrixXd s =
      MatrixXd::Identity(d.size(), d.size()) - g * (c.transpose() * g).ldlt().solve(MatrixXd(c.transpose()));
  d = s * r.d;
  covariance = s * r.covariance * s.transpose();
}

struct Test {
  double statistic = 0;
  int rank = 0;
};

/// d' Sigma^+ d over some coordinates; eigenvalues that are rounding of the datum's defect do not count.
Test joint_test(const VectorXd& d, const MatrixXd& covariance, const std::vector<Index>& rows) {
  const VectorXd part = d(rows);
  const MatrixXd sigma = covariance(rows, rows);
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(sigma);
  const double floor = 1e-9 * eigen.eigenvalues().maxCoeff();
  Test test;
  for (Index k = 0; k < part.size(); ++k) {
    if (eigen.eigenvalues()[k] <= floor) continue;
    const double projected = eigen.eigenvectors().col(k).dot(part);
    test.statistic += projected * projected / eigen.eigenvalues()[k];
    ++test.rank;
  }
  return test;
}

std::vector<Index> rows_of(const std::vector<char>& stable) {
  std::vector<Index> rows;
  for (size_t i = 0; i < stable.size(); ++i)
    for (Index c = 0; stable[i] && c < 3; ++c) rows.push_back(static_cast<Index>(3 * i) + c);
  return rows;
}

/// Among the stable points the one without which the rest fits best.
size_t worst_point(const Difference& r, const std::vector<char>& stable, bool free_datum) {
  double least = std::numeric_limits<double>::infinity();
  size_t worst = 0;
  VectorXd d;
  MatrixXd covariance;
  for (size_t i = 0; i < stable.size(); ++i) {
    if (!stable[i]) continue;
    std::vector<char> without = stable;
    without[i] = 0;
    to_datum(r, without, free_datum, d, covariance);
    const Test test = joint_test(d, covariance, rows_of(without));
    if (test.statistic >= least) continue;
    least = test.statistic;
    worst = i;
  }
  return worst;
}

}  // namespace

Comparison compare_epochs(const Epoch& first, const Epoch& second, const ComparisonOptions& options) {
  check(first, "first");
  check(second, "second");
  const Difference r = difference_of(first, second);
  std::vector<char> stable(r.ids.size(), 1);
  VectorXd d;
  MatrixXd covariance;
  Comparison result;
  for (bool initial = true;; initial = false) {
    to_datum(r, stable, options.free_datum, d, covariance);
    const Test test = joint_test(d, covariance, rows_of(stable));
    const double critical = test.rank > 0 ? chi_squared_quantile(1 - options.alpha, test.rank) : 0.0;
    if (initial) {
      result.statistic = test.statistic;
      result.rank = test.rank;
      result.critical = critical;
      result.congruent = test.statistic <= critical;
    }
    if (test.statistic <= critical || std::count(stable.begin(), stable.end(), 1) <= 3) break;
    const size_t worst = worst_point(r, stable, options.free_datum);
    stable[worst] = 0;
    result.excluded.push_back(r.ids[worst]);
  }
  const double delta = adjustment::non_centrality(options.alpha0, options.power);
  const double critical = chi_squared_quantile(1 - options.alpha0, 3);
  for (size_t i = 0; i < r.ids.size(); ++i) {
    const auto k = static_cast<Index>(3 * i);
    Movement m;
    m.id = r.ids[i];
    m.movement = d.segment<3>(k);
    m.sigma = covariance.diagonal().segment<3>(k).cwiseMax(0).cwiseSqrt();
    m.statistic = joint_test(d, covariance, {k, k + 1, k + 2}).statistic;
    m.stable = stable[i];
    m.moved = !stable[i] || m.statistic > critical;
    m.detectable_height = delta * m.sigma.z();
    result.movements.push_back(std::move(m));
  }
  return result;
}

}  // namespace plumbline::survey

#include "photo/block/control_suspects.hpp"

#include <algorithm>
#include <initializer_list>

#include "geometry/linear_algebra/decompositions.hpp"
#include "geometry/statistics.hpp"

namespace plumbline::block {
namespace {

/// What errors of some control points would explain: chi-squared with `freedom` if there are none.
struct Explained {
  double test = 0;
  int freedom = 0;
  Eigen::VectorXd off;  ///< survey minus model [m]
};

Explained explained_by(std::initializer_list<std::size_t> points, const Eigen::MatrixXd& seen,
                       const Eigen::MatrixXd& weight, const Eigen::VectorXd& pull, double variance) {
  constexpr double controlled = 0.01;  // part of an error that has to show
  std::vector<Eigen::Index> b;
  for (const std::size_t k : points)
    for (Eigen::Index c = 0; c < 3; ++c) b.push_back(3 * static_cast<Eigen::Index>(k) + c);
  const linear_algebra::GeneralizedSymmetricEigen shown(seen(b, b), weight(b, b));
  const Eigen::VectorXd parts = shown.eigenvectors().transpose() * pull(b);
  Explained result;
  result.off = Eigen::VectorXd::Zero(parts.size());
  for (Eigen::Index i = 0; i < parts.size(); ++i) {
    const double part = shown.eigenvalues()(i);
    if (!(part > controlled)) continue;
    ++result.freedom;
    result.test += parts(i) * parts(i) / (part * variance);
    result.off -= shown.eigenvectors().col(i) * (parts(i) / part);
  }
  return result;
}

}  // namespace

ControlSuspects suspects_of(const Eigen::MatrixXd& seen, const Eigen::MatrixXd& weight, const Eigen::VectorXd& pull,
                            double variance) {
  constexpr double level = 1e-3;  // over all points
  ControlSuspects result;
  const auto count = static_cast<std::size_t>(pull.size() / 3);
  const auto limit = [&](int freedom) {
    return chi_squared_quantile(1 - level / static_cast<double>(count), std::max(1, freedom));
  };
  std::vector<Explained> alone;
  const auto excess = [&](std::size_t k) { return alone[k].test - limit(alone[k].freedom); };
  std::size_t worst = count;
  for (std::size_t k = 0; k < count; ++k) {
    alone.push_back(explained_by({k}, seen, weight, pull, variance));
    if (alone[k].freedom < 3) result.hidden.push_back(k);
    if (alone[k].freedom > 0 && excess(k) > (worst < count ? excess(worst) : 0)) worst = k;
  }
  if (worst == count) return result;
  result.worst = {worst, alone[worst].test, limit(alone[worst].freedom), alone[worst].off};
  for (std::size_t k = 0; k < count; ++k) {
    if (k == worst || !(excess(k) > 0)) continue;
    const Explained both = explained_by({worst, k}, seen, weight, pull, variance);
    if (both.test - alone[k].test <= limit(both.freedom - alone[k].freedom)) result.rivals.push_back(k);
  }
  return result;
}

}  // namespace plumbline::block

#include "survey/epochs/epoch_motion.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/linear_algebra/decompositions.hpp"
#include "geometry/statistics.hpp"

namespace plumbline::survey {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

Level level_of(double length, double sigma, double level) {
  constexpr double kOneSided = 1.645;
  if (!(level > 0)) return Level::below;
  return length > level ? Level::reached : length + kOneSided * sigma > level ? Level::may_be_reached : Level::below;
}

double critical_of(double alpha, int rank, int degrees) {
  return degrees > 0 ? rank * fisher_f_quantile(1 - alpha, rank, degrees) : chi_squared_quantile(1 - alpha, rank);
}

/// Directions in which the datum leaves a point free, as columns: a point that carries it alone cannot move at all, of
/// two none across their line. What is computed there is rounding, and no movement. `before`: the largest variance
/// before it was laid on them.
MatrixXd free_directions(const MatrixXd& covariance, double before) {
  constexpr double kNothing = 1e-9;  // of the variance that a point had: rounding leaves 1e-14
  const Index n = covariance.rows();
  if (n == 0) return MatrixXd(0, 0);
  const linear_algebra::SymmetricEigen spectrum(covariance);
  const Index none = (spectrum.eigenvalues().array() <= kNothing * before).count();
  return none == 0 ? MatrixXd(MatrixXd::Identity(n, n)) : MatrixXd(spectrum.eigenvectors().rightCols(n - none));
}

double largest_before(const SeenPoint& s, const std::vector<Index>& axes) {
  return VectorXd(s.before(axes)).maxCoeff();
}

/// Which of `seen` measured each coordinate first.
std::array<size_t, 3> first_of_each(const std::vector<SeenPoint>& seen) {
  std::array<size_t, 3> first = {};
  for (size_t c = 0; c < 3; ++c)
    first[c] = static_cast<size_t>(
        std::find_if(seen.begin(), seen.end(), [&](const SeenPoint& s) { return s.compared[c]; }) - seen.begin());
  return first;
}

/// What an epoch says of the line: `rows` of a + v t, a and v in the free directions of the point.
struct LineRows {
  MatrixXd design;      ///< m x 2n
  VectorXd place;       ///< m [m]
  MatrixXd covariance;  ///< m x m
};

LineRows rows_of(const SeenPoint& s, const MatrixXd& directions, const std::vector<Index>& point_axes,
                 const Eigen::Vector3d& origin, double since) {
  const std::vector<Index> axes = s.axes();
  const MatrixXd c = s.covariance(axes, axes), own = free_directions(c, largest_before(s, axes));
  std::vector<Index> of_point;  // rows of `directions` that this epoch has
  for (const Index axis : axes)
    of_point.push_back(std::find(point_axes.begin(), point_axes.end(), axis) - point_axes.begin());
  const MatrixXd along = own.transpose() * MatrixXd(directions(of_point, Eigen::all));
  LineRows rows;
  rows.design.resize(along.rows(), 2 * along.cols());
  rows.design << along, since * along;
  rows.place = own.transpose() * VectorXd(Eigen::Vector3d(s.at - origin)(axes));
  rows.covariance = own.transpose() * c * own;
  return rows;
}

/// Velocities that the epochs show, as columns: with the places reduced out of the normal equations, what is left of
/// information. A direction that one epoch alone leaves free has none.
MatrixXd shown_velocities(const MatrixXd& normal) {
  constexpr double kNothing = 1e-9;  // of the largest information
  const Index n = normal.rows() / 2;
  const MatrixXd of_both = normal.topRightCorner(n, n), of_velocity = normal.bottomRightCorner(n, n);
  const MatrixXd reduced =
      of_velocity - of_both.transpose() * linear_algebra::solve_symmetric(normal.topLeftCorner(n, n), of_both);
  const linear_algebra::SymmetricEigen spectrum(reduced);
  const double largest = linear_algebra::SymmetricEigen(of_velocity).eigenvalues()[n - 1];
  const Index none = (spectrum.eigenvalues().array() <= kNothing * largest).count();
  return spectrum.eigenvectors().rightCols(n - none);
}

}  // namespace

void add_movements(const std::vector<SeenPoint>& seen, const SeriesOptions& options, int degrees, SeriesPoint& point) {
  const std::array<size_t, 3> first = first_of_each(seen);
  point.first = seen.front().epoch;
  for (size_t c = 0; c < 3; ++c) point.reference[c] = first[c] < seen.size() ? seen[first[c]].epoch : point.first;
  for (size_t k = 1; k < seen.size(); ++k) {
    std::vector<Index> axes = seen[k].axes();
    std::erase_if(axes, [&](Index c) { return first[c] == k; });
    if (axes.empty()) continue;
    SeriesPoint::At at;
    at.epoch = seen[k].epoch;
    at.movement.setConstant(std::numeric_limits<double>::quiet_NaN());
    at.sigma = at.movement;
    const auto n = static_cast<Index>(axes.size());
    VectorXd d(n);
    MatrixXd c = seen[k].covariance(axes, axes);
    double before = largest_before(seen[k], axes);
    for (Index i = 0; i < n; ++i) {
      const SeenPoint& reference = seen[first[axes[i]]];
      const Index a = axes[i];
      d[i] = seen[k].at[a] - reference.at[a];
      before = std::max(before, reference.before[a]);
      for (Index j = 0; j < n; ++j) {  // epochs are independent of each other
        const Index b = axes[j];
        if (&seen[first[b]] == &reference) c(i, j) += reference.covariance(a, b);
      }
      at.movement[a] = d[i], at.sigma[a] = std::sqrt(std::max(0.0, c(i, i)));
    }
    const MatrixXd directions = free_directions(c, before);
    const VectorXd free = directions.transpose() * d;
    if (free.size() > 0)
      at.statistic = free.dot(linear_algebra::solve_symmetric(directions.transpose() * c * directions, free));
    at.critical = critical_of(options.alpha0, static_cast<int>(std::max<Index>(1, free.size())), degrees);
    at.moved = at.statistic > at.critical;
    const double length = d.norm(),
                 sigma = length > 0 ? std::sqrt(d.dot(c * d)) / length : std::sqrt(c.diagonal().maxCoeff());
    at.warning = level_of(length, sigma, options.warning_level);
    at.alarm = level_of(length, sigma, options.alarm_level);
    point.at.push_back(at);
  }
}

void add_velocity(const std::vector<SeenPoint>& seen, const SeriesOptions& options, int degrees, SeriesPoint& point) {
  const std::array<size_t, 3> first = first_of_each(seen);
  std::vector<Index> axes;
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  for (Index c = 0; c < 3; ++c)
    if (const size_t k = first[c]; k < seen.size()) axes.push_back(c), origin[c] = seen[k].at[c];
  point.velocity.setConstant(std::numeric_limits<double>::quiet_NaN());
  for (const Index axis : axes) point.velocity[axis] = 0;
  point.velocity_sigma = point.velocity;
  MatrixXd sum = MatrixXd::Zero(3, 3);
  double before = 0;
  for (const SeenPoint& s : seen) {
    sum(s.axes(), s.axes()) += s.covariance(s.axes(), s.axes());
    before += largest_before(s, s.axes());
  }
  const MatrixXd directions = free_directions(sum(axes, axes), before);
  const Index n = directions.cols();
  point.velocity_critical = critical_of(options.alpha0, static_cast<int>(std::max<Index>(1, n)), degrees);
  if (n == 0) return;
  std::vector<LineRows> line;
  MatrixXd normal = MatrixXd::Zero(2 * n, 2 * n);
  VectorXd right = VectorXd::Zero(2 * n);
  Index equations = 0;
  for (const SeenPoint& s : seen) {
    const LineRows& rows = line.emplace_back(rows_of(s, directions, axes, origin, s.time - seen.front().time));
    const MatrixXd weighted = linear_algebra::solve_symmetric(rows.covariance, rows.design);
    normal += rows.design.transpose() * weighted;
    right += weighted.transpose() * rows.place;
    equations += rows.place.size();
  }
  const MatrixXd shown = shown_velocities(normal);
  const Index m = shown.cols();
  const MatrixXd lost = directions * (MatrixXd::Identity(n, n) - shown * shown.transpose());
  constexpr double kRounding = 1e-6;
  for (size_t a = 0; a < axes.size(); ++a)
    if (lost.row(static_cast<Index>(a)).norm() > kRounding)
      point.velocity[axes[a]] = point.velocity_sigma[axes[a]] = std::numeric_limits<double>::quiet_NaN();
  if (m == 0) return;
  MatrixXd part = MatrixXd::Zero(2 * n, n + m);  // a and v from the unknowns
  part.topLeftCorner(n, n).setIdentity(), part.bottomRightCorner(n, m) = shown;
  const auto factor = MatrixXd(part.transpose() * normal * part).ldlt();
  const VectorXd unknowns = factor.solve(VectorXd(part.transpose() * right)), x = part * unknowns;
  const MatrixXd q = MatrixXd(factor.solve(MatrixXd::Identity(n + m, n + m))).bottomRightCorner(m, m),
                 turned = directions * shown;
  const VectorXd v = unknowns.tail(m), along = turned * v, variances = (turned * q * turned.transpose()).diagonal();
  for (size_t a = 0; a < axes.size(); ++a) {
    const auto i = static_cast<Index>(a);
    if (!std::isfinite(point.velocity[axes[a]])) continue;
    point.velocity[axes[a]] = along[i], point.velocity_sigma[axes[a]] = std::sqrt(std::max(0.0, variances[i]));
  }
  point.velocity_critical = critical_of(options.alpha0, static_cast<int>(m), degrees);
  point.velocity_statistic = v.dot(linear_algebra::solve_symmetric(q, v));
  point.moves = point.velocity_statistic > point.velocity_critical;
  if (equations <= n + m) return;
  for (const LineRows& rows : line) {
    const VectorXd r = rows.place - rows.design * x;
    point.misfit += r.dot(linear_algebra::solve_symmetric(rows.covariance, r));
  }
  point.misfit_critical = critical_of(options.alpha0, static_cast<int>(equations - n - m), degrees);
}

}  // namespace plumbline::survey

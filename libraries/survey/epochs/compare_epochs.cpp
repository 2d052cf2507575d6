#include "survey/epochs/compare_epochs.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "geometry/linear_algebra/decompositions.hpp"
#include "geometry/similarity.hpp"
#include "geometry/statistics.hpp"
#include "least_squares/problem/reliability.hpp"
#include "plumbline/stop.hpp"

namespace plumbline::survey {

namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

void check(const Epoch& e, const char* which) {
  const auto n = static_cast<Index>(3 * e.ids.size());
  if (e.coordinates.size() == n && e.covariance.rows() == n && e.covariance.cols() == n) return;
  throw std::runtime_error(std::string("the ") + which + " epoch has " + std::to_string(e.ids.size()) +
                           " points but no covariance of all their coordinates; give the points of survey.adjust");
}

/// Which of E, N, H a point has in both epochs: a bench mark has a height only, a point of a plane network has none.
using Components = std::array<bool, 3>;

/// The common points of both epochs. Components that a point does not have are zero and without variance.
struct Pair {
  std::vector<std::string> ids;
  std::vector<Components> has;
  VectorXd first, second;                        // 3n
  MatrixXd first_covariance, second_covariance;  // 3n x 3n
};

struct Difference {
  std::vector<std::string> ids;
  std::vector<Components> has;
  VectorXd d;           // second minus first
  MatrixXd covariance;  // sum of both
  VectorXd place;       // 3n: coordinates of the first epoch
};

Pair common_points(const Epoch& first, const Epoch& second, Comparison& result) {
  std::vector<Index> a, b;
  Pair pair;
  for (size_t i = 0; i < first.ids.size(); ++i) {
    const auto at = std::find(second.ids.begin(), second.ids.end(), first.ids[i]);
    if (at == second.ids.end()) {
      result.only_first.push_back(first.ids[i]);
      continue;
    }
    const auto k = static_cast<Index>(3 * i), l = static_cast<Index>(3 * (at - second.ids.begin()));
    // A coordinate that is not there, or held without error in both epochs, is nothing to compare.
    Components has;
    for (Index c = 0; c < 3; ++c) {
      const double variance = first.covariance(k + c, k + c) + second.covariance(l + c, l + c);
      has[c] = std::isfinite(first.coordinates[k + c]) && std::isfinite(second.coordinates[l + c]) && variance > 0;
    }
    has[0] = has[1] = has[0] && has[1];  // half a position is none
    if (!has[0] && !has[2]) {
      result.incomplete.push_back(first.ids[i]);
      continue;
    }
    pair.ids.push_back(first.ids[i]);
    pair.has.push_back(has);
    for (Index c = 0; c < 3; ++c) {
      a.push_back(k + c);
      b.push_back(l + c);
    }
  }
  for (const std::string& id : second.ids)
    if (std::find(first.ids.begin(), first.ids.end(), id) == first.ids.end()) result.only_second.push_back(id);
  pair.first = first.coordinates(a);
  pair.second = second.coordinates(b);
  pair.first_covariance = first.covariance(a, a);
  pair.second_covariance = second.covariance(b, b);
  for (size_t i = 0; i < pair.ids.size(); ++i)
    for (size_t c = 0; c < 3; ++c) {
      if (pair.has[i][c]) continue;
      const auto row = static_cast<Index>(3 * i + c);
      pair.first[row] = pair.second[row] = 0;
      for (MatrixXd* m : {&pair.first_covariance, &pair.second_covariance})
        m->row(row).setZero(), m->col(row).setZero();
    }
  return pair;
}

/// Best rotation onto the first epoch over the stable points: about the vertical, or any where tilts are free
/// (Kabsch 1976; in the plane in closed form).
Matrix3d turn_of(const Pair& p, const std::vector<char>& stable, int free_motions, Vector3d& from, Vector3d& to) {
  from = to = Vector3d::Zero();
  for (size_t c = 0; c < 3; ++c) {
    double n = 0;
    for (size_t i = 0; i < stable.size(); ++i) n += stable[i] && p.has[i][c];
    for (size_t i = 0; i < stable.size(); ++i) {
      if (!stable[i] || !p.has[i][c]) continue;
      const auto row = static_cast<Index>(3 * i + c);
      from[static_cast<Index>(c)] += p.second[row] / n;
      to[static_cast<Index>(c)] += p.first[row] / n;
    }
  }
  Matrix3d h = Matrix3d::Zero();
  for (size_t i = 0; i < stable.size(); ++i)
    if (stable[i] && p.has[i][0] && (free_motions < 6 || p.has[i][2]))
      h += (p.second.segment<3>(static_cast<Index>(3 * i)) - from) *
           (p.first.segment<3>(static_cast<Index>(3 * i)) - to).transpose();
  if (free_motions < 4) return Matrix3d::Identity();
  if (free_motions < 6) {
    const double angle = std::atan2(h(0, 1) - h(1, 0), h(0, 0) + h(1, 1));
    return Eigen::AngleAxisd(angle, Vector3d::UnitZ()).toRotationMatrix();
  }
  return rotation_of_moment(h.transpose());
}

/// Free networks may lie anywhere: the second epoch is first laid onto the first, so that the rest is small and linear.
Difference difference_of(const Pair& p, const std::vector<char>& stable, int free_motions) {
  Difference r{p.ids, p.has, p.second - p.first, p.first_covariance + p.second_covariance, p.first};
  if (free_motions == 0) return r;
  Vector3d from, to;
  const Matrix3d turn = turn_of(p, stable, free_motions, from, to);
  const Index n = p.first.size() / 3;
  for (Index i = 0; i < n; ++i) {
    r.d.segment<3>(3 * i) = turn * (p.second.segment<3>(3 * i) - from) + to - p.first.segment<3>(3 * i);
    for (Index c = 0; c < 3; ++c)
      if (!p.has[i][c]) r.d[3 * i + c] = 0;
    for (Index k = 0; k < n; ++k)
      r.covariance.block<3, 3>(3 * i, 3 * k) = p.first_covariance.block<3, 3>(3 * i, 3 * k) +
                                               turn * p.second_covariance.block<3, 3>(3 * i, 3 * k) * turn.transpose();
  }
  return r;
}

/// Columns of what the epochs are free to differ by, about the centre of the points; 3n x 0 to 7. What moves no
/// coordinate that is there (a turn of bench marks) is left out.
MatrixXd motions(const Difference& r, int count) {
  const Index n = r.d.size() / 3;
  MatrixXd g = MatrixXd::Zero(3 * n, count);
  Vector3d centre = Vector3d::Zero();
  for (Index c = 0; c < 3; ++c) {
    double sum = 0, present = 0;
    for (Index i = 0; i < n; ++i)
      if (r.has[i][c]) sum += r.place[3 * i + c], ++present;
    if (present > 0) centre[c] = sum / present;
  }
  for (Index i = 0; i < n && count > 0; ++i) {
    const Vector3d p = r.place.segment<3>(3 * i) - centre;
    g.block<3, 3>(3 * i, 0).setIdentity();
    Index column = 3;
    if (count >= 4) g.block<3, 1>(3 * i, column++) = Vector3d(p.y(), -p.x(), 0);
    if (count >= 6) g.block<3, 1>(3 * i, column++) = Vector3d(0, p.z(), -p.y());
    if (count >= 6) g.block<3, 1>(3 * i, column++) = Vector3d(-p.z(), 0, p.x());
    if (count == 5 || count == 7) g.block<3, 1>(3 * i, column) = p;
    for (Index c = 0; c < 3; ++c)
      if (!r.has[i][c]) g.row(3 * i + c).setZero();
  }
  std::vector<Index> moving;
  for (Index k = 0; k < g.cols(); ++k)
    if (g.col(k).cwiseAbs().maxCoeff() > 0) moving.push_back(k);
  return g(Eigen::all, moving);
}

/// Rows of the coordinates of some points that are there.
std::vector<Index> rows_of(const Difference& r, const std::vector<size_t>& points) {
  std::vector<Index> rows;
  for (const size_t i : points)
    for (size_t c = 0; c < 3; ++c)
      if (r.has[i][c]) rows.push_back(static_cast<Index>(3 * i + c));
  return rows;
}

std::vector<Index> all_rows(const Difference& r) {
  std::vector<size_t> all(r.ids.size());
  std::iota(all.begin(), all.end(), size_t{0});
  return rows_of(r, all);
}

/// A free network knows nothing of its own position: compared as if it did, its inner constraints would be divided by
/// nothing and every point would have moved.
void require_regular(const MatrixXd& covariance, int motions) {
  const VectorXd scale = covariance.diagonal().cwiseMax(1e-30).cwiseSqrt().cwiseInverse();
  const Eigen::LDLT<MatrixXd> factor(scale.asDiagonal() * covariance * scale.asDiagonal());
  if (factor.info() == Eigen::Success && factor.vectorD().minCoeff() > 1e-13) return;
  throw std::runtime_error("the covariance of the differences is singular with " + std::to_string(motions) +
                           " motions of the datum left free: a network has more freedom than that; compare the epochs "
                           "with datum=free, or hold both on points with coordinates");
}

/// R of the header: what all statistics are made of; zero where a point has no coordinate.
MatrixXd weights_of(const Difference& r, const MatrixXd& all_motions) {
  const std::vector<Index> rows = all_rows(r);
  const MatrixXd g = all_motions(rows, Eigen::all);
  MatrixXd full = MatrixXd::Zero(r.d.size(), r.d.size());
  // The term in G makes the covariance of two inner-constrained networks regular; R does not depend on its size.
  MatrixXd c = r.covariance(rows, rows);
  if (g.cols() > 0) {
    const double scale = c.diagonal().mean();
    for (Index k = 0; k < g.cols(); ++k)
      c += scale / std::max(1e-12, g.col(k).cwiseAbs2().maxCoeff()) * g.col(k) * g.col(k).transpose();
  }
  require_regular(c, static_cast<int>(g.cols()));
  const MatrixXd p = linear_algebra::solve_symmetric(c, MatrixXd::Identity(c.rows(), c.cols()));
  const MatrixXd pg = p * g;
  full(rows, rows) =
      g.cols() == 0 ? p : MatrixXd(p - pg * linear_algebra::solve_symmetric(g.transpose() * pg, pg.transpose()));
  return full;
}

/// Of a sum of `rank` squares, with a variance that is known (0 degrees) or was estimated.
double critical_value(double alpha, int rank, int degrees) {
  return degrees > 0 ? rank * fisher_f_quantile(1 - alpha, rank, degrees) : chi_squared_quantile(1 - alpha, rank);
}

/// Which points are to be left out until the rest is congruent.
class Localisation {
 public:
  Localisation(const Difference& r, const MatrixXd& g, const ComparisonOptions& options)
      : r_(r), options_(options), weights_(weights_of(r, g)), u_(weights_ * r.d) {
    rank_ = static_cast<int>(all_rows(r).size()) - static_cast<int>(g.cols());
    total_ = r.d.dot(u_);
  }

  int rank() const { return rank_; }
  /// Without some points.
  double statistic(const std::vector<size_t>& without) const {
    if (without.empty()) return total_;
    const auto rows = rows_of(r_, without);
    const VectorXd u = u_(rows);
    return std::max(0.0, total_ - u.dot(linear_algebra::solve_symmetric(weights_(rows, rows), u)));
  }
  int rank(const std::vector<size_t>& without) const { return rank_ - static_cast<int>(rows_of(r_, without).size()); }
  double critical(const std::vector<size_t>& without) const {
    const int left = rank(without);
    return left > 0 ? critical_value(options_.alpha, left, options_.variance_degrees) : 0.0;
  }

  std::vector<Exclusion> run(std::vector<size_t>& out) const {
    std::vector<Exclusion> exclusions;
    while (statistic(out) > critical(out) && some_may_go(out)) {
      stop_point();
      exclusions.push_back(exclude_one(out));
    }
    return exclusions;
  }

 private:
  /// More coordinates must be left than the datum takes, or nothing would be compared.
  bool may_go(const std::vector<size_t>& out, size_t point) const {
    return rank(out) > static_cast<int>(rows_of(r_, {point}).size());
  }
  bool some_may_go(const std::vector<size_t>& out) const {
    for (size_t i = 0; i < r_.ids.size(); ++i)
      if (std::find(out.begin(), out.end(), i) == out.end() && may_go(out, i)) return true;
    return false;
  }
  /// The one without which the rest fits best; the others that would do are told.
  Exclusion exclude_one(std::vector<size_t>& out) const {
    std::vector<double> without(r_.ids.size(), std::numeric_limits<double>::infinity());
    for (size_t i = 0; i < r_.ids.size(); ++i) {
      if (std::find(out.begin(), out.end(), i) != out.end() || !may_go(out, i)) continue;
      std::vector<size_t> trial = out;
      trial.push_back(i);
      without[i] = statistic(trial);
    }
    const auto best = static_cast<size_t>(std::min_element(without.begin(), without.end()) - without.begin());
    out.push_back(best);
    Exclusion e{r_.ids[best], without[best], critical(out), {}};
    for (size_t i = 0; i < without.size(); ++i)
      if (i != best && without[i] <= e.critical) e.alternatives.push_back(r_.ids[i]);
    return e;
  }

  const Difference& r_;
  const ComparisonOptions& options_;
  MatrixXd weights_;
  VectorXd u_;
  int rank_ = 0;
  double total_ = 0;
};

/// Movements in the datum of the stable points: d2 = S d, S = I - G H, H = (E'G)^-1 E' with E the stable rows of G.
void add_movements(const Difference& r, const MatrixXd& g, const std::vector<char>& stable,
                   const ComparisonOptions& options, Comparison& result) {
  MatrixXd h = g.transpose();
  for (size_t i = 0; i < stable.size(); ++i)
    if (!stable[i]) h.middleCols(static_cast<Index>(3 * i), 3).setZero();
  if (g.cols() > 0) h = linear_algebra::solve_symmetric(h * g, h);
  const VectorXd d = r.d - g * (h * r.d);
  const MatrixXd hc = h * r.covariance, hch = hc * h.transpose();
  const double delta = least_squares::non_centrality(options.alpha0, options.power);
  for (size_t i = 0; i < r.ids.size(); ++i) {
    const auto k = static_cast<Index>(3 * i);
    const MatrixXd gi = g.middleRows(k, 3), cross = gi * hc.middleCols(k, 3);
    Movement m;
    m.id = r.ids[i];
    const std::vector<Index> rows = rows_of(r, {i});
    std::vector<Index> own;  // of the point's three
    for (const Index row : rows) own.push_back(row - k);
    m.rank = static_cast<int>(rows.size());
    m.critical = critical_value(options.alpha0, m.rank, options.variance_degrees);
    m.covariance = r.covariance.block<3, 3>(k, k) - cross - cross.transpose() + gi * hch * gi.transpose();
    const VectorXd movement = d(rows);
    m.statistic = movement.dot(linear_algebra::solve_symmetric(m.covariance(own, own), movement));
    for (const Index c : own) {
      m.position[c] = r.place[k + c];
      m.movement[c] = d[k + c];
      m.sigma[c] = std::sqrt(std::max(0.0, m.covariance(c, c)));
    }
    m.stable = stable[i];
    // Left out of the datum is not yet moved: with many points one fits least by chance, or because another moved.
    m.moved = m.statistic > m.critical;
    m.detectable_height = delta * m.sigma.z();
    result.movements.push_back(std::move(m));
  }
}

bool are_rivals(size_t moved, size_t others) {
  constexpr size_t kOneIn = 3;
  return kOneIn * std::min(moved, others) >= moved + others;
}

/// The points that stay, where the others are congruent among themselves too, and could carry the datum as well.
std::vector<std::string> other_body(const Localisation& localisation, const Difference& r,
                                    const std::vector<char>& stays, const std::vector<size_t>& out, size_t needed,
                                    int free_motions) {
  std::vector<size_t> rest;
  for (size_t i = 0; i < stays.size(); ++i)
    if (stays[i]) rest.push_back(i);
  constexpr size_t kFewest = 3;  // that are a body where most others are of the other
  if (free_motions == 0 || out.size() < needed || rest.size() < needed) return {};
  if (!are_rivals(out.size(), rest.size()) && std::min(out.size(), rest.size()) < kFewest) return {};
  if (localisation.rank(rest) <= 0 || localisation.statistic(rest) > localisation.critical(rest)) return {};
  std::vector<std::string> ids;
  for (const size_t i : rest) ids.push_back(r.ids[i]);
  return ids;
}

}  // namespace

bool Comparison::bodies_are_rivals() const {
  return !other_body.empty() && are_rivals(excluded.size(), other_body.size());
}

Epoch part_of(const Epoch& epoch, const std::vector<char>& keep) {
  Epoch part;
  std::vector<size_t> which;
  for (size_t i = 0; i < epoch.ids.size(); ++i) {
    if (!keep[i]) continue;
    part.ids.push_back(epoch.ids[i]);
    which.push_back(i);
  }
  std::vector<Index> rows;
  for (const size_t i : which)
    for (size_t c = 0; c < 3; ++c) rows.push_back(static_cast<Index>(3 * i + c));
  part.coordinates = epoch.coordinates(rows);
  part.covariance = epoch.covariance(rows, rows);
  return part;
}

Comparison compare_epochs(const Epoch& first, const Epoch& second, const ComparisonOptions& stated) {
  check(first, "first");
  check(second, "second");
  Comparison result;
  ComparisonOptions options = stated;
  Pair pair = common_points(first, second, result);
  if (stated.first_variance.degrees_of_freedom > 0 || stated.second_variance.degrees_of_freedom > 0) {
    result.variances = test_variances(stated.first_variance, stated.second_variance, stated.alpha);
    pair.first_covariance *= result.variances.first_factor;
    pair.second_covariance *= result.variances.second_factor;
    options.variance_degrees = result.variances.degrees_of_freedom;
  }
  const bool plan = std::any_of(pair.has.begin(), pair.has.end(), [](const Components& has) { return has[0]; });
  const size_t needed = options.free_motions < 3 ? 1 : !plan ? 2 : options.free_motions >= 5 ? 4 : 3;
  if (pair.ids.size() < needed)
    throw std::runtime_error("the two epochs have " + std::to_string(pair.ids.size()) +
                             " points in common that can be compared; a comparison needs at least " +
                             std::to_string(needed));
  std::vector<char> stable(pair.ids.size(), 1);
  // Laid on the points that stay; a second time if these are fewer than was thought.
  for (int pass = 0;; ++pass) {
    stop_point();
    const Difference r = difference_of(pair, stable, options.free_motions);
    const MatrixXd g = motions(r, options.free_motions);
    const Localisation localisation(r, g, options);
    std::vector<size_t> out;
    if (options.localise) result.excluded = localisation.run(out);
    std::vector<char> found(pair.ids.size(), 1);
    for (size_t i : out) found[i] = 0;
    if (found != stable && pass < 5) {
      stable = found;
      continue;
    }
    result.rank = localisation.rank();
    result.statistic = localisation.statistic({});
    result.critical = localisation.critical({});
    result.congruent = result.statistic <= result.critical;
    add_movements(r, g, found, options, result);
    result.other_body = other_body(localisation, r, found, out, needed, options.free_motions);
    return result;
  }
}

}  // namespace plumbline::survey

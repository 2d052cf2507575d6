#include "photo/block/control_suspects.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "geometry/linear_algebra/decompositions.hpp"
#include "geometry/statistics.hpp"

namespace plumbline::block {
namespace {

constexpr double determined = 1e-6;  // part of an unknown error that has to show; rounding leaves 1e-12

std::vector<Eigen::Index> rows_of(const std::vector<std::size_t>& points) {
  std::vector<Eigen::Index> rows;
  for (const std::size_t k : points)
    for (Eigen::Index c = 0; c < 3; ++c) rows.push_back(3 * static_cast<Eigen::Index>(k) + c);
  return rows;
}

/// Directions of an error that show, each scaled so that `seen` of it is 1.
Eigen::MatrixXd shown_of(const Eigen::MatrixXd& seen, const Eigen::MatrixXd& weight, double least) {
  const linear_algebra::GeneralizedSymmetricEigen shown(seen, weight);
  std::vector<Eigen::Index> kept;
  for (Eigen::Index i = 0; i < seen.rows(); ++i)
    if (shown.eigenvalues()(i) > least) kept.push_back(i);
  return shown.eigenvectors()(Eigen::all, kept) * shown.eigenvalues()(kept).cwiseSqrt().cwiseInverse().asDiagonal();
}

class Search {
 public:
  Search(const Eigen::MatrixXd& seen, const Eigen::MatrixXd& weight, const Eigen::VectorXd& pull, double variance)
      : seen_(seen), weight_(weight), pull_(pull), variance_(variance) {}

  std::size_t count() const { return static_cast<std::size_t>(pull_.size() / 3); }

  /// From now on errors of these points are unknowns beside that which is tested.
  void add_unknown(const std::vector<std::size_t>& points) {
    const std::vector<Eigen::Index> u = rows_of(points), all = all_rows();
    const Eigen::MatrixXd shown = shown_of(seen_beside(u, u), weight_(u, u), determined);
    const Eigen::MatrixXd more = shown.transpose() * seen_beside(u, all);
    const Eigen::VectorXd taken = shown.transpose() * pull_beside(u);
    const Eigen::Index before = across_.rows();
    across_.conservativeResize(before + more.rows(), pull_.size());
    across_.bottomRows(more.rows()) = more;
    taken_.conservativeResize(across_.rows());
    taken_.tail(more.rows()) = taken;
  }

  /// What an error of the point would explain; with `other`, that one's error is an unknown as well.
  SuspectedControl tested(std::size_t point, std::optional<std::size_t> other = std::nullopt) const {
    constexpr double controlled = 0.01;  // part of an error that has to show
    const std::vector<Eigen::Index> b = rows_of({point});
    Eigen::MatrixXd seen = seen_beside(b, b);
    Eigen::VectorXd pull = pull_beside(b);
    if (other) {
      const std::vector<Eigen::Index> o = rows_of({*other});
      const Eigen::MatrixXd shown = shown_of(seen_beside(o, o), weight_(o, o), determined);
      const Eigen::MatrixXd across = shown.transpose() * seen_beside(o, b);
      seen -= across.transpose() * across;
      pull -= across.transpose() * (shown.transpose() * pull_beside(o));
    }
    const Eigen::MatrixXd shown = shown_of(seen, weight_(b, b), controlled);
    const Eigen::VectorXd parts = shown.transpose() * pull;
    constexpr double level = 1e-3;  // over all points
    SuspectedControl result;
    result.point = point;
    result.freedom = static_cast<int>(parts.size());
    result.test = parts.squaredNorm() / variance_;
    result.limit = chi_squared_quantile(1 - level / static_cast<double>(count()), std::max(1, result.freedom));
    result.off = -shown * parts;
    return result;
  }

 private:
  std::vector<Eigen::Index> all_rows() const {
    std::vector<Eigen::Index> rows(static_cast<std::size_t>(pull_.size()));
    std::iota(rows.begin(), rows.end(), 0);
    return rows;
  }
  Eigen::MatrixXd seen_beside(const std::vector<Eigen::Index>& a, const std::vector<Eigen::Index>& b) const {
    if (across_.rows() == 0) return seen_(a, b);
    return seen_(a, b) - across_(Eigen::all, a).transpose() * across_(Eigen::all, b);
  }
  Eigen::VectorXd pull_beside(const std::vector<Eigen::Index>& a) const {
    if (across_.rows() == 0) return pull_(a);
    return pull_(a) - across_(Eigen::all, a).transpose() * taken_;
  }

  const Eigen::MatrixXd& seen_;
  const Eigen::MatrixXd& weight_;
  const Eigen::VectorXd& pull_;
  double variance_;
  Eigen::MatrixXd across_;  ///< of the unknown errors to all coordinates
  Eigen::VectorXd taken_;
};

double excess(const SuspectedControl& point) { return point.freedom > 0 ? point.test - point.limit : 0; }

}  // namespace

ControlSuspects suspects_of(const Eigen::MatrixXd& seen, const Eigen::MatrixXd& weight, const Eigen::VectorXd& pull,
                            double variance, std::vector<std::size_t> unknown) {
  Search search(seen, weight, pull, variance);
  ControlSuspects result;
  for (std::size_t k = 0; k < search.count(); ++k)
    if (search.tested(k).freedom < 3) result.hidden.push_back(k);
  if (!unknown.empty()) search.add_unknown(unknown);
  while (2 * unknown.size() <= search.count()) {  // where half of them is unknown nothing tells of the rest
    RivalControl group;
    std::vector<std::size_t> contradict;
    for (std::size_t k = 0; k < search.count(); ++k) {
      if (std::find(unknown.begin(), unknown.end(), k) != unknown.end()) continue;
      const SuspectedControl found = search.tested(k);
      if (!(excess(found) > 0)) continue;
      if (contradict.empty() || excess(found) > excess(group.worst)) group.worst = found;
      contradict.push_back(k);
    }
    if (contradict.empty()) return result;
    for (const std::size_t k : contradict)
      if (k != group.worst.point && !(excess(search.tested(group.worst.point, k)) > 0)) group.others.push_back(k);
    if (group.others.empty()) {
      result.worst = group.worst;
      return result;
    }
    std::vector<std::size_t> all = group.others;
    all.push_back(group.worst.point);
    search.add_unknown(all);
    unknown.insert(unknown.end(), all.begin(), all.end());
    result.rivals.push_back(std::move(group));
  }
  return result;
}

}  // namespace plumbline::block

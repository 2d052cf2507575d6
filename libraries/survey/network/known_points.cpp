// What the readings say of points that were known before: the difference each would have without its own coordinates.
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "geometry/linear_algebra/decompositions.hpp"
#include "geometry/statistics.hpp"
#include "survey/network/held_points.hpp"
#include "survey/network/network_model.hpp"
#include "survey/words/network_words.hpp"

namespace plumbline::survey {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Chance that any known point of a network in which nothing is wrong is said not to stand; of each it is that share of
/// it (Bonferroni), because they are many questions to one network.
constexpr double kAlphaOfAll = 0.01;
/// Readings that agree less well than this test allows are worse than stated, and their share in a difference with
/// them.
constexpr double kClearly = 0.001;

/// One group of known coordinates after the adjustment: v, its weights, and M = P Qvv P.
struct Known {
  const CoordinateGroup* group;
  VectorXd u;  ///< P v
  MatrixXd m;
  double scale;  ///< largest weight
};

Known known_of(const CoordinateGroup& group, const NetworkModel& model, const NetworkProblem& problem,
               const least_squares::Solution& solution, const least_squares::Cofactors& cofactors) {
  const auto n = static_cast<Index>(group.components.size());
  VectorXd v(n);
  std::vector<int> unknowns;
  std::vector<Index> rows;
  for (Index k = 0; k < n; ++k) {
    const auto& [point, axis] = group.components[k];
    const int block = problem.point_blocks[model.index.at(point)];
    v[k] = problem.problem.parameters[block].value[axis] - group.values[k];
    const int unknown = solution.unknowns(block, axis);
    if (unknown < 0) continue;
    unknowns.push_back(unknown);
    rows.push_back(k);
  }
  MatrixXd q = MatrixXd::Zero(n, n);  // of the adjusted coordinates
  q(rows, rows) = cofactors.joint(unknowns);
  const MatrixXd p = linear_algebra::solve_symmetric(group.covariance, MatrixXd::Identity(n, n));
  return {&group, p * v, p - p * q * p, p.diagonal().maxCoeff()};
}

/// d = M^-1 u over what can be tested: directions in which nothing but the point itself says where it is have no
/// weight in M (Baarda 1968, several rows as one hypothesis).
KnownPoint difference_of(const Known& known, const std::string& id) {
  // Of a weight: rounding of P - P Q P is some 1e-12 of it, a reading that shares a point with ten others 1e-4.
  constexpr double kTestable = 1e-8;
  KnownPoint result;
  result.id = id;
  std::vector<Index> rows;
  for (size_t k = 0; k < known.group->components.size(); ++k)
    if (known.group->components[k].point == id) rows.push_back(static_cast<Index>(k));
  for (const Index row : rows)
    result.sigma[known.group->components[row].axis] = std::sqrt(known.group->covariance(row, row));
  const VectorXd u = known.u(rows);
  const linear_algebra::SymmetricEigen eigen(MatrixXd(known.m(rows, rows)));
  VectorXd d = VectorXd::Zero(u.size());
  for (Index k = 0; k < u.size(); ++k) {
    const double weight = eigen.eigenvalues()[k];
    if (weight < kTestable * known.scale) continue;
    const double along = eigen.eigenvectors().col(k).dot(u);
    d += eigen.eigenvectors().col(k) * (along / weight);
    result.statistic += along * along / weight;
    ++result.rank;
  }
  result.explained = result.statistic;
  for (size_t k = 0; k < rows.size(); ++k)
    result.difference[known.group->components[rows[k]].axis] = d[static_cast<Index>(k)];
  return result;
}

/// What the difference of a point is held against: its stated accuracies, or what all the rest shows of them where that
/// is clearly more. Without the rest a survey that is noisier than stated would have every known point wrong.
double critical_of(const KnownPoint& k, const least_squares::Solution& solution, bool estimated, double alpha) {
  const int degrees = solution.degrees_of_freedom() - k.rank;
  const double rest = solution.sum_of_squares() - k.explained;
  if (degrees <= 0 || (!estimated && rest <= chi_squared_quantile(1 - kClearly, degrees)))
    return chi_squared_quantile(1 - alpha, k.rank);
  return k.rank * fisher_f_quantile(1 - alpha, k.rank, degrees) * rest / degrees;
}

std::string difference_in_words(const KnownPoint& k) {
  std::string text = k.id;
  for (int axis = 0; axis < 3; ++axis) {
    if (std::isnan(k.sigma[axis])) continue;
    const double mm = 1e3 * k.difference[axis];
    text += std::string(axis && text.size() > k.id.size() ? ", " : " ") + "ENH"[axis] + (mm < 0 ? " " : " +") +
            fixed_digits(mm, 1);
  }
  return text + " mm";
}

}  // namespace

std::vector<KnownPoint> compare_with_known(const NetworkModel& model, const NetworkProblem& problem,
                                           const least_squares::Solution& solution,
                                           const least_squares::Cofactors& cofactors, bool estimated) {
  if (model.datum == DatumMode::inner) return {};
  std::vector<KnownPoint> result;
  for (const CoordinateGroup& group : model.survey.coordinates) {
    if (!group.is_control) continue;
    const Known known = known_of(group, model, problem, solution, cofactors);
    std::vector<std::string> ids;
    for (const auto& c : group.components)
      if (std::find(ids.begin(), ids.end(), c.point) == ids.end()) ids.push_back(c.point);
    for (const std::string& id : ids) result.push_back(difference_of(known, id));
  }
  for (KnownPoint& held : test_held_points(model, problem, solution, cofactors)) result.push_back(std::move(held));
  const auto tested = std::count_if(result.begin(), result.end(), [](const KnownPoint& k) { return k.rank > 0; });
  for (KnownPoint& k : result)
    if (k.rank > 0) k.critical = critical_of(k, solution, estimated, kAlphaOfAll / static_cast<double>(tested));
  // The neighbours of a wrong one may differ by more than itself.
  std::stable_sort(result.begin(), result.end(), [](const KnownPoint& a, const KnownPoint& b) {
    if (a.stands() != b.stands()) return b.stands();
    return a.stands() ? a.difference.norm() > b.difference.norm() + 1e-7 : a.statistic > b.statistic + 1e-6;
  });
  return result;
}

Finding in_words(const std::vector<KnownPoint>& known) {
  constexpr size_t kShown = 4;
  const bool stand = std::all_of(known.begin(), known.end(), [](const KnownPoint& k) { return k.stands(); });
  const auto tested =
      static_cast<size_t>(std::count_if(known.begin(), known.end(), [](const KnownPoint& k) { return k.rank > 0; }));
  Finding finding{stand ? Finding::Severity::note : Finding::Severity::warning, "", {}};
  finding.text =
      std::to_string(known.size()) + " known point" + (known.size() > 1 ? "s" : "") + ", as measured minus as known: ";
  for (const KnownPoint& k : known) {
    if (k.rank == 0 || finding.points.size() == kShown) continue;
    finding.text += (finding.points.empty() ? "" : "; ") + difference_in_words(k);
    finding.points.push_back(k.id);
  }
  if (tested > kShown) finding.text += "; " + std::to_string(tested - kShown) + " less";
  if (!stand)
    finding.text +=
        ". They do not fit each other and the readings: one of them is wrong or has moved, or a reading "
        "between them; if they are only less good than that, give their standard deviations (keyed in: known_sigma)";
  return finding;
}

std::set<std::string> known_ids(const NetworkModel& m) {
  std::set<std::string> ids;
  for (const CoordinateGroup& g : m.survey.coordinates)
    if (g.is_control)
      for (const auto& c : g.components) ids.insert(c.point);
  for (std::size_t i = 0; i < m.ids.size(); ++i)
    for (const CoordinateRole role : m.roles[i])
      if (role == CoordinateRole::fixed) ids.insert(m.ids[i]);
  for (const Point& p : m.survey.points)
    if (m.index.contains(p.id) && std::all_of(p.known.begin(), p.known.end(), [](bool k) { return k; }))
      ids.insert(p.id);
  return ids;
}

}  // namespace plumbline::survey

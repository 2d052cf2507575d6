#include "building/judgement/difference.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <map>
#include <set>
#include <stdexcept>
#include <utility>

#include "building/judgement/factor_in_place.hpp"
#include "geometry/linear_algebra/decompositions.hpp"
#include "plumbline/stop.hpp"

namespace plumbline::judgement {

std::map<std::string, std::size_t> index_points(const PointSet& points, const std::string& what) {
  if (points.ids.size() != points.positions.size())
    throw std::runtime_error(what + " points: " + std::to_string(points.ids.size()) + " ids but " +
                             std::to_string(points.positions.size()) + " positions");
  const auto expected = static_cast<Eigen::Index>(3 * points.ids.size());
  if (points.covariance.size() != 0 && points.covariance.size() != expected)
    throw std::runtime_error(what + " points: the covariance is " + std::to_string(points.covariance.size()) + " x " +
                             std::to_string(points.covariance.size()) + ", expected " + std::to_string(expected) +
                             " x " + std::to_string(expected) + " for " + std::to_string(points.ids.size()) +
                             " points");
  std::map<std::string, std::size_t> index;
  for (std::size_t i = 0; i < points.ids.size(); ++i)
    if (!index.emplace(points.ids[i], i).second)
      throw std::runtime_error(what + " points: '" + points.ids[i] + "' occurs twice; ids must be unique");
  return index;
}

Eigen::VectorXd DifferenceSet::heights() const {
  Eigen::VectorXd z(size());
  for (Eigen::Index i = 0; i < z.size(); ++i) z[i] = difference[3 * i + 2];
  return z;
}

namespace {

DifferenceSet without_covariance(const DifferenceSet& all, const std::vector<std::size_t>& positions) {
  const auto n = static_cast<Eigen::Index>(positions.size());
  DifferenceSet part;
  part.difference.resize(3 * n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto from = static_cast<Eigen::Index>(positions[static_cast<std::size_t>(i)]);
    part.anchors.push_back(all.anchors[static_cast<std::size_t>(from)]);
    part.difference.segment<3>(3 * i) = all.difference.segment<3>(3 * from);
  }
  return part;
}

}  // namespace

DifferenceSet DifferenceSet::subset(const std::vector<std::size_t>& positions) const& {
  DifferenceSet part = without_covariance(*this, positions);
  part.covariance = covariance.subset(positions);
  return part;
}

DifferenceSet DifferenceSet::subset(const std::vector<std::size_t>& positions) && {
  DifferenceSet part = without_covariance(*this, positions);
  part.covariance = std::move(covariance).subset(positions);
  return part;
}

namespace {

using Index = Eigen::Index;

/// Blocks of a covariance for two lists of points.
template <typename Row, typename Column>
Eigen::MatrixXd blocks(const BlockCovariance& s, const std::vector<Match>& rows, Row row,
                       const std::vector<Match>& columns, Column column) {
  Eigen::MatrixXd out(3 * static_cast<Index>(rows.size()), 3 * static_cast<Index>(columns.size()));
  for (std::size_t i = 0; i < rows.size(); ++i)
    for (std::size_t j = 0; j < columns.size(); ++j)
      out.block<3, 3>(3 * static_cast<Index>(i), 3 * static_cast<Index>(j)) =
          s.block(static_cast<Index>(row(rows[i])), static_cast<Index>(column(columns[j])));
  return out;
}

/// The covariance of surveyed control, to be solved with. By Cholesky, ten times as fast as by eigenvalues, where it is
/// clearly regular; the survey of a free network has a singular covariance, of which the pseudo-inverse is taken.
class ControlInverse {
 public:
  explicit ControlInverse(const Eigen::MatrixXd& s) : cholesky_(s) {
    constexpr double regular = 1e-9;
    regular_ = cholesky_.info() == Eigen::Success && cholesky_.rcond() > regular;
    if (!regular_) eigen_ = linear_algebra::SymmetricEigen(s);
  }
  bool regular() const { return regular_; }
  /// s⁺ · right.
  Eigen::MatrixXd times(const Eigen::MatrixXd& right) const {
    if (regular_) return cholesky_.solve(right);
    const double limit = 1e-10 * eigen_.eigenvalues().cwiseAbs().maxCoeff();
    Eigen::VectorXd inverse = eigen_.eigenvalues();
    for (Index i = 0; i < inverse.size(); ++i) inverse[i] = inverse[i] > limit ? 1.0 / inverse[i] : 0.0;
    return eigen_.eigenvectors() * (inverse.asDiagonal() * (eigen_.eigenvectors().transpose() * right));
  }

 private:
  Eigen::LLT<Eigen::MatrixXd> cholesky_;
  linear_algebra::SymmetricEigen eigen_;
  bool regular_;
};

std::size_t of_model(const Match& m) { return m.model; }
std::size_t of_survey(const Match& m) { return m.reference; }

/// Control by what the survey correlates.
std::map<std::size_t, std::vector<Match>> by_survey(const PointSet& survey, const std::vector<Match>& control) {
  std::map<std::size_t, std::vector<Match>> clusters;
  for (const Match& c : control) clusters[survey.covariance.cluster_of(static_cast<Index>(c.reference))].push_back(c);
  return clusters;
}

/// Less C + Cᵀ, C = S_M[:,K] S_S[K,K]⁺ S_S[K,:]. What the survey does not correlate goes one after the other, and a few
/// columns at a time: C itself would be as large as `sum`. Of control with a regular covariance the columns of C are
/// those of S_M. Symmetric up to rounding.
void subtract_common(const PointSet& model, const PointSet& survey, const std::vector<Match>& matches,
                     const std::vector<Match>& control, Eigen::MatrixXd& sum) {
  constexpr std::size_t at_a_time = 64;
  const auto subtract = [&](std::size_t place, const auto& columns) {
    const auto to = 3 * static_cast<Index>(place);
    sum.middleCols<3>(to) -= columns;
    sum.middleRows<3>(to) -= columns.transpose();
  };
  std::map<std::size_t, std::vector<std::size_t>> followers;
  for (std::size_t i = 0; i < matches.size(); ++i)
    followers[survey.covariance.cluster_of(static_cast<Index>(matches[i].reference))].push_back(i);
  for (const auto& [cluster, own] : by_survey(survey, control)) {
    const ControlInverse inverse(blocks(survey.covariance, own, of_survey, own, of_survey));
    std::set<std::size_t> held;
    if (inverse.regular())
      for (const Match& c : own) held.insert(c.model);
    std::vector<std::size_t> follow;
    for (const std::size_t i : followers[cluster])
      if (held.contains(matches[i].model))
        subtract(i, blocks(model.covariance, matches, of_model, {matches[i]}, of_model));
      else
        follow.push_back(i);
    if (follow.empty()) continue;
    const Eigen::MatrixXd to_control = blocks(model.covariance, matches, of_model, own, of_model);
    for (std::size_t begin = 0; begin < follow.size(); begin += at_a_time) {
      stop_point();
      std::vector<Match> some;
      for (std::size_t k = begin; k < std::min(follow.size(), begin + at_a_time); ++k)
        some.push_back(matches[follow[k]]);
      const Eigen::MatrixXd cross =
          to_control * inverse.times(blocks(survey.covariance, own, of_survey, some, of_survey));
      for (std::size_t k = 0; k < some.size(); ++k)
        subtract(follow[begin + k], cross.middleCols<3>(3 * static_cast<Index>(k)));
    }
  }
}

/// Of model and survey together, of matches that are correlated in either.
Eigen::MatrixXd sum_of(const PointSet& model, const PointSet& survey, const std::vector<Match>& matches) {
  Eigen::MatrixXd sum = blocks(model.covariance, matches, of_model, matches, of_model);
  for (std::size_t i = 0; i < matches.size(); ++i)
    for (std::size_t j = 0; j < matches.size(); ++j)
      sum.block<3, 3>(3 * static_cast<Index>(i), 3 * static_cast<Index>(j)) +=
          survey.covariance.block(static_cast<Index>(matches[i].reference), static_cast<Index>(matches[j].reference));
  return sum;
}

/// True if no eigenvalue of the symmetric matrix is at or below -`limit`; its lower triangle is made from its upper.
bool is_above(double limit, Eigen::MatrixXd& symmetric) {
  const Eigen::VectorXd diagonal = symmetric.diagonal();
  symmetric.diagonal().array() += limit;
  const bool above = factor_in_place(symmetric);
  restore_lower(diagonal, symmetric);
  return above;
}

/// Makes a covariance of what is one but for eigenvalues a little below zero. False where they are below -`limit`. By
/// Cholesky, as eigenvalues of 2400 points take minutes, but where some are a little below zero. Only the part of the
/// control is asked where that is enough: model and survey have a joint covariance if and only if S_S - S_M has no
/// negative eigenvalue on what the control's survey says (the Schur complement of S_M), and a difference of two that
/// have one has a covariance.
bool mend(double limit, const std::vector<Index>& of_control, Eigen::MatrixXd& symmetric) {
  // Where an anchor follows the survey the difference's variance is rounding, and may be negative: within a micrometre
  // that is nothing.
  constexpr double micrometre = 1e-6;
  const auto zero_at_least = [&] { restore_lower(symmetric.diagonal().cwiseMax(0).eval(), symmetric); };
  if (static_cast<Index>(of_control.size()) < symmetric.rows()) {
    Eigen::MatrixXd part = symmetric(of_control, of_control);
    part.diagonal().array() += micrometre * micrometre;
    if (factor_in_place(part)) return zero_at_least(), true;
  }
  if (is_above(micrometre * micrometre, symmetric)) return zero_at_least(), true;
  if (!is_above(limit, symmetric)) return false;
  const linear_algebra::SymmetricEigen eigen(symmetric);
  symmetric = eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0).asDiagonal() * eigen.eigenvectors().transpose();
  return true;
}

/// True where control and other matches share no cluster of the survey and control has a regular covariance there.
bool control_is_apart(const PointSet& survey, const std::vector<Match>& matches, const std::vector<Match>& control) {
  std::set<std::size_t> controlling;
  for (const Match& c : control) controlling.insert(c.model);
  const auto clusters = by_survey(survey, control);
  for (const Match& m : matches)
    if (!controlling.contains(m.model) &&
        clusters.contains(survey.covariance.cluster_of(static_cast<Index>(m.reference))))
      return false;
  return std::all_of(clusters.begin(), clusters.end(), [&](const auto& cluster) {
    return ControlInverse(blocks(survey.covariance, cluster.second, of_survey, cluster.second, of_survey)).regular();
  });
}

/// Matches that have nothing to do with one another are taken apart: what is correlated in either set stays together.
/// But where the survey of the control K is regular and knows nothing of the others u, C[K,K] = S_M[K,K] and
/// C[u,K] = S_M[u,K]: what is left between the two is nothing, and they are apart though the model correlates them.
std::vector<std::vector<std::size_t>> parts_of(const PointSet& model, const PointSet& survey,
                                               const std::vector<Match>& matches, const std::vector<Match>& control) {
  std::set<std::size_t> controlling;
  for (const Match& c : control) controlling.insert(c.model);
  const bool split = !control.empty() && control_is_apart(survey, matches, control);
  Partition partition(matches.size());
  std::map<std::pair<std::size_t, bool>, std::size_t> by_model;  // the first match of a cluster
  std::map<std::size_t, std::size_t> by_reference;
  std::set<std::size_t> matched;
  for (std::size_t i = 0; i < matches.size(); ++i) {
    matched.insert(matches[i].model);
    const bool other = split && !controlling.contains(matches[i].model);
    const std::pair key(model.covariance.cluster_of(static_cast<Index>(matches[i].model)), other);
    partition.join(i, by_model.try_emplace(key, i).first->second);
    const std::size_t surveyed = survey.covariance.cluster_of(static_cast<Index>(matches[i].reference));
    partition.join(i, by_reference.try_emplace(surveyed, i).first->second);
  }
  for (const Match& c : control)
    if (!matched.contains(c.model)) {  // whom it says something of cannot be told: all stay together
      for (std::size_t i = 1; i < matches.size(); ++i) partition.join(0, i);
      break;
    }
  return partition.parts();
}

}  // namespace

DifferenceCovariance difference_covariance(const PointSet& model, const PointSet& survey,
                                           const std::vector<Match>& matches, const std::vector<Match>& control) {
  std::set<std::size_t> controlling;
  for (const Match& c : control) controlling.insert(c.model);
  double largest = 0;
  for (const Match& m : matches)
    largest =
        std::max(largest, (model.covariance.block(static_cast<Index>(m.model), static_cast<Index>(m.model)) +
                           survey.covariance.block(static_cast<Index>(m.reference), static_cast<Index>(m.reference)))
                              .diagonal()
                              .maxCoeff());
  const auto parts = parts_of(model, survey, matches, control);
  const bool whole = parts.size() == 1;
  std::vector<BlockCovariance::Cluster> differences;
  for (const std::vector<std::size_t>& places : parts) {
    stop_point();
    std::vector<Match> own, own_control;
    std::vector<Index> items, of_control;
    for (const std::size_t i : places) {
      const auto row = 3 * static_cast<Index>(own.size());
      own.push_back(matches[i]), items.push_back(static_cast<Index>(i));
      if (!controlling.contains(matches[i].model)) continue;
      own_control.push_back(matches[i]);
      of_control.insert(of_control.end(), {row, row + 1, row + 2});
    }
    Eigen::MatrixXd difference = sum_of(model, survey, own);
    if (const auto& common = whole ? control : own_control; !common.empty()) {
      subtract_common(model, survey, own, common, difference);
      // An adjustment may add a little to the control's variances (a hundredth of a millimetre, to keep weights
      // finite), so small negative eigenvalues are zeros; a thousandth of the largest variance is more than that and
      // means that C is wrong.
      if (!mend(1e-3 * largest, of_control, difference))
        return {difference_covariance(model, survey, matches, {}).matrix, false};
    }
    differences.push_back({items, std::move(difference)});
  }
  return {BlockCovariance(std::move(differences), static_cast<Index>(matches.size()), 3), true};
}

}  // namespace plumbline::judgement

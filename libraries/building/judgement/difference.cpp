#include "building/judgement/difference.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <map>
#include <set>
#include <stdexcept>

#include "building/judgement/factor_in_place.hpp"
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

DifferenceSet DifferenceSet::subset(const std::vector<std::size_t>& positions) const {
  const auto n = static_cast<Eigen::Index>(positions.size());
  DifferenceSet part;
  part.difference.resize(3 * n);
  part.covariance = covariance.subset(positions);
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto from = static_cast<Eigen::Index>(positions[i]);
    part.anchors.push_back(anchors[from]);
    part.difference.segment<3>(3 * i) = difference.segment<3>(3 * from);
  }
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

/// right · s⁺, s symmetric. By Cholesky, ten times as fast as by eigenvalues, where s is clearly regular; the survey of
/// a free network has a singular covariance, of which the pseudo-inverse is taken.
Eigen::MatrixXd times_inverse(const Eigen::MatrixXd& right, const Eigen::MatrixXd& s) {
  constexpr double regular = 1e-9;
  const Eigen::LLT<Eigen::MatrixXd> cholesky(s);
  if (cholesky.info() == Eigen::Success && cholesky.rcond() > regular)
    return cholesky.solve(right.transpose()).transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(s);
  const double limit = 1e-10 * eigen.eigenvalues().cwiseAbs().maxCoeff();
  Eigen::VectorXd inverse = eigen.eigenvalues();
  for (Index i = 0; i < inverse.size(); ++i) inverse[i] = inverse[i] > limit ? 1.0 / inverse[i] : 0.0;
  return right * eigen.eigenvectors() * inverse.asDiagonal() * eigen.eigenvectors().transpose();
}

/// Less C + Cᵀ, C = S_M[:,K] S_S[K,K]⁺ S_S[K,:]. What the survey does not correlate goes one after the other, and a few
/// columns at a time: C itself would be as large as `sum`. Symmetric up to rounding.
void subtract_common(const PointSet& model, const PointSet& survey, const std::vector<Match>& matches,
                     const std::vector<Match>& control, Eigen::MatrixXd& sum) {
  constexpr std::size_t at_a_time = 64;
  const auto of_model = [](const Match& m) { return m.model; };
  const auto of_survey = [](const Match& m) { return m.reference; };
  const auto cluster_of = [&](const Match& m) { return survey.covariance.cluster_of(static_cast<Index>(m.reference)); };
  std::map<std::size_t, std::vector<Match>> controls;
  for (const Match& c : control) controls[cluster_of(c)].push_back(c);
  std::map<std::size_t, std::vector<std::size_t>> followers;
  for (std::size_t i = 0; i < matches.size(); ++i) followers[cluster_of(matches[i])].push_back(i);
  for (const auto& [cluster, own] : controls) {
    const Eigen::MatrixXd gain = times_inverse(blocks(model.covariance, matches, of_model, own, of_model),
                                               blocks(survey.covariance, own, of_survey, own, of_survey));
    const std::vector<std::size_t>& follow = followers[cluster];
    for (std::size_t begin = 0; begin < follow.size(); begin += at_a_time) {
      stop_point();
      std::vector<Match> some;
      for (std::size_t k = begin; k < std::min(follow.size(), begin + at_a_time); ++k)
        some.push_back(matches[follow[k]]);
      const Eigen::MatrixXd cross = gain * blocks(survey.covariance, own, of_survey, some, of_survey);
      for (std::size_t k = 0; k < some.size(); ++k) {
        const auto to = 3 * static_cast<Index>(follow[begin + k]), from = 3 * static_cast<Index>(k);
        sum.middleCols<3>(to) -= cross.middleCols<3>(from);
        sum.middleRows<3>(to) -= cross.middleCols<3>(from).transpose();
      }
    }
  }
}

/// Of model and survey together, of matches that are correlated in either.
Eigen::MatrixXd sum_of(const PointSet& model, const PointSet& survey, const std::vector<Match>& matches) {
  const auto of_model = [](const Match& m) { return m.model; };
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
/// Cholesky, as eigenvalues of 2400 points take minutes, but where some are a little below zero.
bool mend(double limit, Eigen::MatrixXd& symmetric) {
  // Where an anchor follows the survey the difference's variance is rounding, and may be negative: within a micrometre
  // that is nothing.
  constexpr double micrometre = 1e-6;
  if (is_above(micrometre * micrometre, symmetric)) {
    symmetric.diagonal() = symmetric.diagonal().cwiseMax(0).eval();
    return true;
  }
  if (!is_above(limit, symmetric)) return false;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(symmetric);
  symmetric = eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0).asDiagonal() * eigen.eigenvectors().transpose();
  return true;
}

/// Matches that have nothing to do with one another are taken apart: what is correlated in either set stays together.
std::vector<std::vector<std::size_t>> parts_of(const PointSet& model, const PointSet& survey,
                                               const std::vector<Match>& matches, const std::vector<Match>& control) {
  Partition partition(matches.size());
  std::map<std::size_t, std::size_t> by_model, by_survey;  // the first match of a cluster
  std::map<std::size_t, std::size_t> match_of_model;
  for (std::size_t i = 0; i < matches.size(); ++i) {
    match_of_model[matches[i].model] = i;
    partition.join(
        i, by_model.try_emplace(model.covariance.cluster_of(static_cast<Index>(matches[i].model)), i).first->second);
    partition.join(
        i,
        by_survey.try_emplace(survey.covariance.cluster_of(static_cast<Index>(matches[i].reference)), i).first->second);
  }
  for (const Match& c : control)
    if (!match_of_model.contains(c.model)) {  // whom it says something of cannot be told: all stay together
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
    std::vector<Index> items;
    for (const std::size_t i : places) {
      own.push_back(matches[i]), items.push_back(static_cast<Index>(i));
      if (controlling.contains(matches[i].model)) own_control.push_back(matches[i]);
    }
    Eigen::MatrixXd difference = sum_of(model, survey, own);
    if (const auto& common = whole ? control : own_control; !common.empty()) {
      subtract_common(model, survey, own, common, difference);
      // An adjustment may add a little to the control's variances (a hundredth of a millimetre, to keep weights
      // finite), so small negative eigenvalues are zeros; a thousandth of the largest variance is more than that and
      // means that C is wrong.
      if (!mend(1e-3 * largest, difference)) return {difference_covariance(model, survey, matches, {}).matrix, false};
    }
    differences.push_back({items, std::move(difference)});
  }
  return {BlockCovariance(std::move(differences), static_cast<Index>(matches.size()), 3), true};
}

}  // namespace plumbline::judgement

// What an adjusted block says of its observations: redundancy, standardised residuals, variance components.
#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "photo/bundle/adjust.hpp"
#include "photo/bundle/parts.hpp"

namespace plumbline::bundle {

namespace {

/// tr J Q Jᵀ of a linear term: what it has no redundancy for. Its unknowns are kept ones.
double trace_of_adjusted(const Layout& layout, const Elimination& elimination, const KnownRows& term) {
  constexpr Eigen::Index batch = 64;
  std::vector<int> at;
  for (int column : term.columns)
    for (int b : term.blocks)
      if (const int within = column - layout.offset(b); within >= 0 && within < layout.size(b)) {
        at.push_back(elimination.kept_offset(b) + within);
        break;
      }
  const Eigen::VectorXd scale = elimination.scale()(at);
  double sum = 0;
  for (Eigen::Index first = 0; first < term.jacobian.rows(); first += batch) {
    const Eigen::Index count = std::min(batch, term.jacobian.rows() - first);
    Eigen::MatrixXd functionals = Eigen::MatrixXd::Zero(elimination.kept_count(), count);
    functionals(at, Eigen::all) = scale.asDiagonal() * term.jacobian.middleRows(first, count).transpose();
    sum += elimination.factor().half_solve(functionals).squaredNorm();
  }
  return sum;
}

}  // namespace

double observed_variance(const Problem& problem, const Layout& layout, const Adjusted& adjusted, const Datum& datum) {
  Rows rows;
  double squares = 0, redundancy = adjusted.redundancy();
  const auto add = [&](const auto& terms) {
    for (const auto& term : terms)
      if (evaluate(problem, layout, adjusted.state, term, false, rows)) squares += rows.values().squaredNorm();
  };
  add(problem.image_points);
  add(problem.image_tags);
  add(problem.distances);
  const Elimination& elimination = *adjusted.elimination;
  std::unique_ptr<Cofactors> all;  // only if a term knows an eliminated block
  for (size_t k = 0; k < problem.known.size(); ++k) {
    const KnownRows term = evaluate(problem, layout, adjusted.state, problem.known[k]);
    redundancy -= static_cast<double>(term.residual.size());
    if (std::all_of(term.blocks.begin(), term.blocks.end(), [&](int b) { return elimination.eliminated(b) < 0; })) {
      redundancy += trace_of_adjusted(layout, elimination, term);
      continue;
    }
    if (!all) all = std::make_unique<Cofactors>(problem, layout, adjusted.state, elimination, datum);
    redundancy += static_cast<double>(term.residual.size()) - all->known(adjusted.state, k).residual_cofactor.trace();
  }
  return redundancy > 1e-6 ? squares / redundancy : 0;
}

Reliability reliability_of(const Problem& problem, const Adjusted& adjusted) {
  static const double non_centrality = least_squares::non_centrality(0.001, 0.8);
  Reliability result;
  result.points.resize(problem.image_points.size());
  result.tags.resize(problem.image_tags.size());
  result.distances.resize(problem.distances.size());
  result.groups.resize(problem.groups.size());
  for (size_t g = 0; g < problem.groups.size(); ++g) result.groups[g].name = problem.groups[g].name;
  const auto add = [&](int group, const Eigen::Ref<const Eigen::VectorXd>& residuals,
                       const Eigen::Ref<const Eigen::MatrixXd>& cofactor) {
    auto& sums = result.groups[group];
    sums.sum_of_squares += residuals.squaredNorm();
    sums.redundancy += cofactor.trace();
    sums.rows += static_cast<int>(residuals.size());
  };
  const auto factor_of = [&](int group) { return problem.groups[group].sigma_factor; };
  adjusted.cofactors->visit_rows(adjusted.state, [&](const Elimination::TermRef& term, const Rows& rows,
                                                     const Eigen::Ref<const Eigen::MatrixXd>& cofactor) {
    const size_t i = static_cast<size_t>(term.index);
    if (term.kind == Elimination::TermRef::Kind::point) {
      const auto& o = problem.image_points[i];
      const auto quality =
          least_squares::row_statistics(o.whitening / factor_of(o.group), rows.values(), cofactor, non_centrality);
      std::copy(quality.begin(), quality.end(), result.points[i].begin());
      add(o.group, rows.values(), cofactor);
    } else if (term.kind == Elimination::TermRef::Kind::tag) {
      const auto& o = problem.image_tags[i];
      Eigen::Matrix<double, 8, 8> whitening = Eigen::Matrix<double, 8, 8>::Zero();
      for (int k = 0; k < 4; ++k) whitening.block<2, 2>(2 * k, 2 * k) = o.whitening[k] / factor_of(o.group);
      const auto quality = least_squares::row_statistics(whitening, rows.values(), cofactor, non_centrality);
      std::copy(quality.begin(), quality.end(), result.tags[i].begin());
      add(o.group, rows.values(), cofactor);
    } else {
      const auto& o = problem.distances[i];
      result.distances[i] =
          least_squares::row_statistics(Eigen::MatrixXd::Constant(1, 1, 1 / (o.sigma * factor_of(o.group))),
                                        rows.values(), cofactor, non_centrality)[0];
      add(o.group, rows.values(), cofactor);
    }
  });
  for (size_t k = 0; k < problem.known.size(); ++k) {
    const auto& term = problem.known[k];
    const Cofactors::KnownQuality quality = adjusted.cofactors->known(adjusted.state, k);
    if (term.whitening.rows() == term.whitening.cols())
      result.known.push_back(least_squares::row_statistics(
          term.whitening / factor_of(term.group), quality.rows.residual, quality.residual_cofactor, non_centrality));
    else
      result.known.emplace_back();
    add(term.group, quality.rows.residual, quality.residual_cofactor);
  }
  for (auto& group : result.groups)
    if (group.redundancy > 1e-6) group.factor = group.sum_of_squares / group.redundancy;
  return result;
}

}  // namespace plumbline::bundle

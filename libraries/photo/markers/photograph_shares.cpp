#include "photo/markers/photograph_shares.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <set>

#include "geometry/linear_algebra/decompositions.hpp"
#include "photo/bundle/terms.hpp"
#include "photo/markers/camera_evidence.hpp"

namespace plumbline::markers {
namespace {

/// The rows' columns with the effects behind them, over `columns`.
Eigen::MatrixXd spread(const PhotographRows& rows, const std::vector<int>& columns) {
  Eigen::MatrixXd wide = Eigen::MatrixXd::Zero(rows.misclosure.size(), static_cast<Eigen::Index>(columns.size()));
  for (std::size_t k = 0; k < rows.columns.size(); ++k) {
    const auto at = std::lower_bound(columns.begin(), columns.end(), rows.columns[k]) - columns.begin();
    wide.col(at) = rows.kept.col(static_cast<Eigen::Index>(k));
  }
  if (rows.effects.size() > 0) wide.rightCols(rows.effects.cols()) = rows.effects;
  return wide;
}

int kept_column(const bundle::Problem& problem, int unknown) {
  return unknown - 6 * static_cast<int>(problem.images.size());
}

/// `effects`: whitened.
PhotographRows rows_of(const bundle::Problem& problem, const bundle::Layout& layout, int image,
                       const bundle::Rows& from, Eigen::MatrixXd effects) {
  PhotographRows rows;
  rows.photograph = image;
  rows.misclosure = -from.values();
  rows.effects = std::move(effects);
  rows.kept.resize(from.rows, from.columns - 6);
  for (int k = 0; k < from.parts; ++k) {
    const auto& part = from.part[k];
    if (part.block == layout.block({bundle::Kind::image, image})) {
      rows.own = from.jacobian(k);
      continue;
    }
    rows.kept.middleCols(static_cast<Eigen::Index>(rows.columns.size()), part.size) = from.jacobian(k);
    for (int c = 0; c < part.size; ++c) rows.columns.push_back(kept_column(problem, layout.offset(part.block) + c));
  }
  return rows;
}

}  // namespace

std::vector<PhotographShare> shares_of(int photographs, int kept_count, const std::vector<PhotographRows>& all) {
  const auto blocks = static_cast<std::size_t>(photographs);
  std::vector<std::set<int>> touched(blocks);
  Eigen::Index most_effects = 0, size = 0;
  for (const PhotographRows& rows : all) {
    most_effects = std::max(most_effects, rows.effects.cols()), size = rows.own.cols();
    touched[rows.photograph].insert(rows.columns.begin(), rows.columns.end());
  }
  std::vector<PhotographShare> shares(blocks);
  std::vector<Eigen::MatrixXd> own(blocks), coupling(blocks);
  std::vector<Eigen::VectorXd> right(blocks);
  for (std::size_t b = 0; b < blocks; ++b) {
    PhotographShare& share = shares[b];
    share.columns.assign(touched[b].begin(), touched[b].end());
    for (Eigen::Index e = 0; e < most_effects; ++e) share.columns.push_back(kept_count + static_cast<int>(e));
    const auto n = static_cast<Eigen::Index>(share.columns.size());
    share.score = Eigen::VectorXd::Zero(n), share.information = Eigen::MatrixXd::Zero(n, n);
    own[b] = Eigen::MatrixXd::Zero(size, size), coupling[b] = Eigen::MatrixXd::Zero(size, n);
    right[b] = Eigen::VectorXd::Zero(size);
  }
  for (const PhotographRows& rows : all) {
    const auto b = static_cast<std::size_t>(rows.photograph);
    const Eigen::MatrixXd kept = spread(rows, shares[b].columns);
    shares[b].information += kept.transpose() * kept, shares[b].score += kept.transpose() * rows.misclosure;
    own[b] += rows.own.transpose() * rows.own, coupling[b] += rows.own.transpose() * kept;
    right[b] += rows.own.transpose() * rows.misclosure;
  }
  for (std::size_t b = 0; b < blocks; ++b) {
    const Eigen::LDLT<Eigen::MatrixXd> factor(own[b]);
    shares[b].pose_by = -factor.solve(coupling[b]);
    shares[b].information += coupling[b].transpose() * shares[b].pose_by;
    shares[b].score -= coupling[b].transpose() * factor.solve(right[b]);
  }
  return shares;
}

std::vector<PhotographShare> shares_of(const bundle::Problem& problem, const bundle::Layout& layout,
                                       const bundle::State& state, const std::vector<int>& heights) {
  std::vector<PhotographRows> all;
  bundle::Rows rows;
  const auto effects_of = [&](const auto& term, const Eigen::Vector2d& pixel, const Eigen::Matrix2d& whitening) {
    const int camera = problem.images[term.image].camera;
    return Eigen::Matrix2d(whitening * effects_at(pixel, heights[camera]) / problem.groups[term.group].sigma_factor);
  };
  for (const bundle::ImagePoint& point : problem.image_points)
    if (bundle::evaluate(problem, layout, state, point, true, rows))
      all.push_back(rows_of(problem, layout, point.image, rows, effects_of(point, point.observed, point.whitening)));
  for (const bundle::ImageTag& tag : problem.image_tags) {
    if (!bundle::evaluate(problem, layout, state, tag, true, rows)) continue;
    Eigen::MatrixXd effects(8, effect_count);
    for (std::size_t q = 0; q < 4; ++q)
      effects.middleRows<2>(2 * static_cast<Eigen::Index>(q)) = effects_of(tag, tag.corners[q], tag.whitening[q]);
    all.push_back(rows_of(problem, layout, tag.image, rows, std::move(effects)));
  }
  return shares_of(static_cast<int>(problem.images.size()), kept_column(problem, layout.unknown_count()), all);
}

std::vector<int> interior_columns(const bundle::Problem& problem, const bundle::Layout& layout, int camera) {
  std::vector<int> columns(BrownCamera::parameter_count, -1);
  int next = kept_column(problem, layout.offset(layout.block({bundle::Kind::camera, camera})));
  for (const int value : layout.free_values(camera)) columns[value] = next++;
  return columns;
}

Eigen::MatrixXd kept_cofactor(const bundle::Problem& problem, const bundle::Layout& layout,
                              const bundle::Cofactors& cofactors) {
  std::vector<int> kept;
  for (int b = static_cast<int>(problem.images.size()); b < layout.block_count(); ++b)
    if (layout.size(b) > 0) kept.push_back(b);
  return cofactors.joint(kept);
}

Eigen::VectorXd change_without(const PhotographShare& share, const Eigen::MatrixXd& cofactor,
                               const std::vector<int>& wanted) {
  std::vector<int> kept;  // without the effects
  for (const int column : share.columns)
    if (column < cofactor.rows()) kept.push_back(column);
  const auto n = static_cast<Eigen::Index>(kept.size());
  const Eigen::MatrixXd left =
      Eigen::MatrixXd::Identity(n, n) - share.information.topLeftCorner(n, n) * cofactor(kept, kept);
  return -cofactor(wanted, kept) * linear_algebra::solve(left, share.score.head(n));
}

}  // namespace plumbline::markers

#include "photo/markers/photograph_effects.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "geometry/linear_algebra/decompositions.hpp"
#include "plumbline/stop.hpp"

namespace plumbline::markers {
namespace {

/// Bounds of the strengths; below the lower one an effect is nothing beside the noise of any corner.
Strengths bounds(const EffectModel&, bool upper) {
  Strengths s;
  if (upper)
    s.log << std::log(0.3), std::log(300), std::log(300), std::log(400), std::log(30);
  else
    s.log << std::log(1e-6), std::log(1e-3), std::log(1e-3), 0, std::log(1e-3);
  return s;
}

/// Of the columns of EffectModel::effects_.
Eigen::Matrix<double, 5, 1> rms_of(const Strengths& strengths) {
  const double point = strengths.of(Strengths::principal_point), rows = strengths.of(Strengths::rows);
  return (Eigen::Matrix<double, 5, 1>() << strengths.of(Strengths::focus), point, point, rows, rows).finished();
}

/// Principal columns of `rows' deviations from their mean, rms 1; those that hardly differ are left out.
void add_main_columns(Eigen::MatrixXd rows, int most, std::vector<Eigen::VectorXd>& columns) {
  constexpr double hardly = 1e-3;  // [rad], relative: nobody holds a camera as still
  rows.rowwise() -= rows.colwise().mean().eval();
  const auto n = static_cast<double>(rows.rows());
  const linear_algebra::SingularValues svd(rows, Eigen::ComputeThinU);
  for (Eigen::Index k = 0; k < std::min<Eigen::Index>(most, svd.singularValues().size()); ++k)
    if (svd.singularValues()(k) > hardly * std::sqrt(n)) columns.emplace_back(std::sqrt(n) * svd.matrixU().col(k));
}

/// Inverse of a normal matrix, by way of its correlations; directions that are not determined get none.
Eigen::MatrixXd inverse_of(const Eigen::MatrixXd& normal, double& log_determinant) {
  const Eigen::VectorXd scale = normal.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const linear_algebra::SymmetricEigen axes(scale.asDiagonal() * normal * scale.asDiagonal());
  const double least = 1e-11 * axes.eigenvalues().maxCoeff();
  const Eigen::VectorXd values = axes.eigenvalues().cwiseMax(least);
  log_determinant = values.array().log().sum() - 2 * scale.array().log().sum();
  return scale.asDiagonal() * axes.eigenvectors() * values.cwiseInverse().asDiagonal() *
         axes.eigenvectors().transpose() * scale.asDiagonal();
}

}  // namespace

EffectModel::EffectModel(const CameraEvidence& evidence, const BrownCamera& camera,
                         const std::vector<RigidTransform>& cam_from_object) {
  parameters_ = static_cast<int>(evidence.parameters.size());
  place_of_.fill(-1);
  for (int k = 0; k < parameters_; ++k) place_of_[evidence.parameters[k]] = k;
  const Eigen::Index q = parameters_ + effect_count, n = static_cast<Eigen::Index>(evidence.score.size());
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(q);
  for (const Eigen::MatrixXd& j : evidence.information) mean += j.diagonal() / static_cast<double>(n);
  scale_ = mean.cwiseMax(1e-300).cwiseSqrt();
  const Eigen::VectorXd inverse = scale_.cwiseInverse();
  for (std::size_t i = 0; i < evidence.score.size(); ++i) {
    scores_.emplace_back(inverse.asDiagonal() * evidence.score[i]);
    information_.emplace_back(inverse.asDiagonal() * evidence.information[i] * inverse.asDiagonal());
    // Directions that a photograph hardly determines hold the errors of the linearisation, too.
    constexpr double well = 1e-3;
    const linear_algebra::SymmetricEigen axes(information_.back());
    const Eigen::VectorXd along = axes.eigenvectors().transpose() * scores_.back();
    for (Eigen::Index k = 0; k < q; ++k)
      if (axes.eigenvalues()(k) > well * axes.eigenvalues()(q - 1))
        squares_ += along(k) * along(k) / axes.eigenvalues()(k), ranks_ += 1;
  }
  effects_ = Eigen::MatrixXd::Zero(q, 5);
  effects_.col(0) = direction({camera.fx, camera.fy});
  effects_.col(1) = direction({0, 0, 1}), effects_.col(2) = direction({0, 0, 0, 1});
  effects_(q - 2, 3) = scale_(q - 2), effects_(q - 1, 4) = scale_(q - 1);
  place_effects_.resize(q, 4);
  place_effects_ << 0.01 * effects_.col(0), 0.002 * camera.width * effects_.middleCols<2>(1),
      direction({0, 0, 0, 0, 0.03});
  Eigen::MatrixXd sight(n, 3), right(n, 3), distance(n, 1);
  for (Eigen::Index i = 0; i < n; ++i) {
    const RigidTransform& pose = cam_from_object[i];
    sight.row(i) = (pose.rotation.conjugate() * Eigen::Vector3d::UnitZ()).transpose();
    right.row(i) = (pose.rotation.conjugate() * Eigen::Vector3d::UnitX()).transpose();
    distance(i, 0) = std::log(std::max(1e-9, pose.translation.norm()));
  }
  add_main_columns(sight, 2, places_), add_main_columns(right, 1, places_), add_main_columns(distance, 1, places_);
}

Eigen::VectorXd EffectModel::direction(const std::array<double, 9>& nine) const {
  Eigen::VectorXd result = Eigen::VectorXd::Zero(parameters_ + effect_count);
  for (std::size_t k = 0; k < nine.size(); ++k)
    if (place_of_[k] >= 0) result(place_of_[k]) = nine[k] * scale_(place_of_[k]);
  return result;
}

std::vector<Eigen::MatrixXd> EffectModel::own_roots(const Strengths& strengths) const {
  return std::vector<Eigen::MatrixXd>(size(),
                                      scale_.cwiseInverse().asDiagonal() * effects_ * rms_of(strengths).asDiagonal());
}

std::vector<Eigen::MatrixXd> EffectModel::common_roots(const Strengths& strengths) const {
  const Eigen::MatrixXd one = strengths.of(Strengths::place) * (scale_.cwiseInverse().asDiagonal() * place_effects_);
  const Eigen::Index d = one.cols();
  std::vector<Eigen::MatrixXd> roots;
  for (std::size_t i = 0; i < size(); ++i) {
    Eigen::MatrixXd root(one.rows(), d * static_cast<Eigen::Index>(places_.size()));
    for (std::size_t a = 0; a < places_.size(); ++a)
      root.middleCols(d * static_cast<Eigen::Index>(a), d) = places_[a](static_cast<Eigen::Index>(i)) * one;
    roots.push_back(root);
  }
  return roots;
}

EffectFit::EffectFit(const EffectModel& model, const Strengths& strengths) : model_(model) {
  const double factor = strengths.of(Strengths::factor);
  const Eigen::MatrixXd root = model.effects_ * rms_of(strengths).asDiagonal();
  const Eigen::Index p = model.parameters_, d = model.place_effects_.cols(),
                     z = static_cast<Eigen::Index>(model.places_.size()), m = p + z * d;
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(m, m);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(m);
  log_likelihood_ = -0.5 * model.squares_ / factor - 0.5 * model.ranks_ * std::log(factor);
  for (std::size_t i = 0; i < model.size(); ++i) {
    const Eigen::MatrixXd j = model.information_[i] / factor, through = j * root;
    const Eigen::VectorXd u = model.scores_[i] / factor, along = root.transpose() * u;
    const Eigen::LLT<Eigen::MatrixXd> inner(Eigen::MatrixXd::Identity(5, 5) + root.transpose() * through);
    const Eigen::VectorXd solved = inner.solve(along);
    log_likelihood_ += 0.5 * along.dot(solved) - Eigen::MatrixXd(inner.matrixL()).diagonal().array().log().sum();
    scores_.emplace_back(u - through * solved);
    information_.emplace_back(j - through * inner.solve(through.transpose()));
    of_place_.emplace_back(information_.back() * model.place_effects_);
    const Eigen::MatrixXd both = model.place_effects_.transpose() * of_place_.back();
    const Eigen::VectorXd place_score = model.place_effects_.transpose() * scores_.back();
    normal.topLeftCorner(p, p) += information_.back().topLeftCorner(p, p);
    right.head(p) += scores_.back().head(p);
    const auto row = static_cast<Eigen::Index>(i);
    for (Eigen::Index a = 0; a < z; ++a) {
      const double at = model.places_[a](row);
      normal.block(0, p + a * d, p, d) += at * of_place_.back().topRows(p);
      right.segment(p + a * d, d) += at * place_score;
      for (Eigen::Index b = a; b < z; ++b)
        normal.block(p + a * d, p + b * d, d, d) += at * model.places_[b](row) * both;
    }
  }
  normal = Eigen::MatrixXd(normal.selfadjointView<Eigen::Upper>());
  const double weight = std::exp(-2 * strengths.log(Strengths::place));
  normal.diagonal().tail(z * d).array() += weight;
  double log_determinant = 0;
  cofactor_ = inverse_of(normal, log_determinant);
  common_ = cofactor_ * right;
  log_likelihood_ +=
      0.5 * right.dot(common_) - 0.5 * log_determinant + 0.5 * static_cast<double>(z * d) * std::log(weight);
}

StepFit EffectFit::fit(const Step& step) const {
  const Eigen::MatrixXd& e = step.directions;
  const Eigen::Index p = model_.parameters_, d = model_.place_effects_.cols(),
                     z = static_cast<Eigen::Index>(model_.places_.size());
  Eigen::MatrixXd coupling = Eigen::MatrixXd::Zero(p + z * d, e.cols());
  Eigen::MatrixXd own = step.sizes.array().square().inverse().matrix().asDiagonal();
  Eigen::VectorXd right = Eigen::VectorXd::Zero(e.cols());
  for (std::size_t i = 0; i < model_.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    const double w = step.weights(row);
    if (w == 0) continue;
    const Eigen::MatrixXd through = information_[i] * e;
    own += w * w * e.transpose() * through;
    right += w * e.transpose() * scores_[i];
    coupling.topRows(p) += w * through.topRows(p);
    const Eigen::MatrixXd with_place = w * of_place_[i].transpose() * e;
    for (Eigen::Index a = 0; a < z; ++a) coupling.middleRows(p + a * d, d) += model_.places_[a](row) * with_place;
  }
  right -= coupling.transpose() * common_;
  const Eigen::MatrixXd left = own - coupling.transpose() * cofactor_ * coupling;
  double log_determinant = 0;
  const Eigen::MatrixXd covariance = inverse_of(0.5 * (left + left.transpose()), log_determinant);
  StepFit result;
  result.by = covariance * right;
  result.sigma = covariance.diagonal().cwiseMax(0).cwiseSqrt();
  result.gain = 0.5 * right.dot(result.by) - 0.5 * log_determinant - step.sizes.array().log().sum();
  return result;
}

void EffectFit::own_scores(const Eigen::MatrixXd& directions, std::vector<Eigen::VectorXd>& scores,
                           std::vector<Eigen::MatrixXd>& information) const {
  const Eigen::Index p = model_.parameters_;
  for (std::size_t i = 0; i < model_.size(); ++i) {
    scores.emplace_back(directions.transpose() * (scores_[i] - information_[i].leftCols(p) * common_.head(p)));
    information.emplace_back(directions.transpose() * information_[i] * directions);
  }
}

void EffectFit::own_steps(const Eigen::MatrixXd& directions, Eigen::MatrixXd& steps,
                          Eigen::VectorXd& information) const {
  std::vector<Eigen::VectorXd> scores;
  std::vector<Eigen::MatrixXd> own;
  own_scores(directions, scores, own);
  const Eigen::Index n = static_cast<Eigen::Index>(model_.size()), k = directions.cols();
  steps.resize(n, k), information.resize(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const Eigen::MatrixXd floor = 1e-9 * own[at].trace() * Eigen::MatrixXd::Identity(k, k);
    steps.row(i) = linear_algebra::solve_symmetric(own[at] + floor, scores[at]).transpose();
    information(i) = own[at].trace();
  }
}

Optimum most_likely(const EffectModel& model, const Strengths& start, const Step* step,
                    const std::vector<Strengths::Kind>& without) {
  const Strengths lower = bounds(model, false), upper = bounds(model, true);
  Optimum best{start, 0};
  for (const Strengths::Kind kind : without) best.strengths.log(kind) = lower.log(kind);
  const auto value_of = [&](const Strengths& at) {
    stop_point();
    const EffectFit fit(model, at);
    return fit.log_likelihood() + (step ? fit.fit(*step).gain : 0);
  };
  best.log_likelihood = value_of(best.strengths);
  Eigen::Array<double, Strengths::count, 1> stride = {1, 1, 1, 0.5, 1};
  for (int round = 0; round < 14 && stride.maxCoeff() > 0.1; ++round)
    for (int k = 0; k < Strengths::count; ++k) {
      if (std::find(without.begin(), without.end(), k) != without.end()) {
        stride(k) = 0;
        continue;
      }
      bool better = false;
      for (const double sign : {1.0, -1.0}) {
        Strengths trial = best.strengths;
        trial.log(k) = std::clamp(trial.log(k) + sign * stride(k), lower.log(k), upper.log(k));
        if (trial.log(k) == best.strengths.log(k)) continue;
        const double value = value_of(trial);
        if (!(value > best.log_likelihood)) continue;
        best = {trial, value}, better = true;
        break;
      }
      if (!better) stride(k) *= 0.5;
    }
  return best;
}

}  // namespace plumbline::markers

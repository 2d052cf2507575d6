#include "markers/camera_splits.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "geometry/random.hpp"
#include "geometry/statistics.hpp"

namespace plumbline::markers {
namespace {

using Split = CameraChange::Split;

constexpr int permutations = 1999;

/// The columns along which `rows` spread most, `count` of them.
Eigen::MatrixXd main_columns(Eigen::MatrixXd rows, Eigen::Index count) {
  rows.rowwise() -= rows.colwise().mean().eval();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> axes(rows.transpose() * rows);
  return rows * axes.eigenvectors().rightCols(count);
}

}  // namespace

Contrast of_parts(Split split, const std::vector<bool>& second, int period) {
  Contrast contrast;
  contrast.split = split, contrast.period = period;
  const auto n = static_cast<Eigen::Index>(second.size());
  contrast.weights.resize(n);
  const double share = static_cast<double>(std::count(second.begin(), second.end(), true)) / static_cast<double>(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const bool in = second[static_cast<std::size_t>(i)];
    contrast.weights(i) = (in ? 1 : 0) - share;
    if (in) contrast.second.push_back(static_cast<int>(i));
  }
  return contrast;
}

void add_parts(Split split, const std::vector<bool>& second, int period, std::vector<Contrast>& contrasts) {
  const auto count = std::count(second.begin(), second.end(), true);
  if (count < smallest_part || static_cast<std::ptrdiff_t>(second.size()) - count < smallest_part) return;
  contrasts.push_back(of_parts(split, second, period));
}

std::vector<Contrast> contrasts_in_order(std::size_t n) {
  std::vector<Contrast> contrasts;
  constexpr std::size_t most_cuts = 60;
  for (std::size_t cut = smallest_part; cut + smallest_part <= n; cut += 1 + n / most_cuts) {
    std::vector<bool> second(n);
    for (std::size_t i = cut; i < n; ++i) second[i] = true;
    add_parts(Split::from_on, second, 0, contrasts);
  }
  Contrast drift = of_parts(Split::drift, [&] {
    std::vector<bool> half(n);
    for (std::size_t i = n / 2; i < n; ++i) half[i] = true;
    return half;
  }());
  for (std::size_t i = 0; i < n; ++i)
    drift.weights(static_cast<Eigen::Index>(i)) = static_cast<double>(i) / static_cast<double>(n - 1) - 0.5;
  contrasts.push_back(drift);
  for (const std::size_t period : {2, 3, 4})
    for (std::size_t first = 0; first < (period == 2 ? 1 : period); ++first) {
      std::vector<bool> second(n);
      for (std::size_t i = first; i < n; i += period) second[i] = true;
      add_parts(Split::every, second, static_cast<int>(period), contrasts);
    }
  return contrasts;
}

void add_upside_down(const std::vector<RigidTransform>& poses, std::vector<Contrast>& contrasts) {
  std::vector<bool> turned;
  Eigen::Matrix3d axes = Eigen::Matrix3d::Zero();
  for (const RigidTransform& pose : poses) {
    const Eigen::Vector3d x = pose.rotation.conjugate() * Eigen::Vector3d::UnitX();
    axes += x * x.transpose();
  }
  const Eigen::Vector3d common = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(axes).eigenvectors().col(2);
  for (const RigidTransform& pose : poses)
    turned.push_back((pose.rotation.conjugate() * Eigen::Vector3d::UnitX()).dot(common) < 0);
  if (2 * std::count(turned.begin(), turned.end(), true) > std::ssize(poses)) turned.flip();
  add_parts(Split::upside_down, turned, 0, contrasts);
}

Places places_of(const std::vector<RigidTransform>& cam_from_object) {
  const auto n = static_cast<Eigen::Index>(cam_from_object.size());
  Eigen::MatrixXd sight(n, 3), right(n, 3), distance(n, 1);
  for (Eigen::Index i = 0; i < n; ++i) {
    const RigidTransform& pose = cam_from_object[static_cast<std::size_t>(i)];
    sight.row(i) = (pose.rotation.conjugate() * Eigen::Vector3d::UnitZ()).transpose();
    right.row(i) = (pose.rotation.conjugate() * Eigen::Vector3d::UnitX()).transpose();
    distance(i, 0) = std::log(std::max(1e-9, pose.translation.norm()));
  }
  return {main_columns(sight, 2), main_columns(right, 1), main_columns(distance, 1)};
}

Eigen::MatrixXd columns_of(const std::vector<Eigen::MatrixXd>& places, std::size_t photographs) {
  constexpr double hardly = 1e-3;  // [rad], relative: nobody holds a camera as still
  const auto n = static_cast<Eigen::Index>(photographs);
  Eigen::MatrixXd columns(n, 0);
  for (const Eigen::MatrixXd& place : places)
    for (Eigen::Index k = 0; k < place.cols(); ++k) {
      if (!(place.col(k).norm() > hardly * std::sqrt(static_cast<double>(n)))) continue;
      columns.conservativeResize(Eigen::NoChange, columns.cols() + 1);
      columns.rightCols(1) = place.col(k).normalized();
    }
  return columns;
}

namespace {

/// Scores of the photographs and what they know, along the directions in question.
struct ScoreGroup {
  Eigen::MatrixXd values;  // one photograph a row
  std::vector<Eigen::MatrixXd> information;
};

/// Covariance of what the photographs have of their own beside their corners' noise, by moments (DerSimonian and Laird
/// 1986): scores u have the covariance K + K T K.
Eigen::MatrixXd common_scatter(const ScoreGroup& group) {
  const Eigen::Index d = group.values.cols();
  Eigen::MatrixXd system = Eigen::MatrixXd::Zero(d * d, d * d), excess = group.values.transpose() * group.values;
  for (const Eigen::MatrixXd& k : group.information) {
    excess -= k;
    for (Eigen::Index i = 0; i < d; ++i)
      for (Eigen::Index j = 0; j < d; ++j) system.block(i * d, j * d, d, d) += k(i, j) * k;
  }
  const Eigen::VectorXd flat = system.ldlt().solve(Eigen::Map<const Eigen::VectorXd>(excess.data(), d * d));
  const Eigen::MatrixXd found = Eigen::Map<const Eigen::MatrixXd>(flat.data(), d, d);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> axes(0.5 * (found + found.transpose()));
  return axes.eigenvectors() * axes.eigenvalues().cwiseMax(0).asDiagonal() * axes.eigenvectors().transpose();
}

/// `columns` beside those of `basis`, orthonormal; those of which less than `least` of their squares is left are dropped.
Eigen::MatrixXd orthonormal(const Eigen::MatrixXd& basis, const Eigen::MatrixXd& columns, double least) {
  Eigen::MatrixXd all = basis;
  for (Eigen::Index k = 0; k < columns.cols(); ++k) {
    Eigen::VectorXd column = columns.col(k);
    const double before = column.norm();
    for (int twice = 0; twice < 2; ++twice) column -= all * (all.transpose() * column).eval();
    if (!(before > 0) || !(column.squaredNorm() > least * before * before)) continue;
    all.conservativeResize(Eigen::NoChange, all.cols() + 1);
    all.rightCols(1) = column.normalized();
  }
  return all.rightCols(all.cols() - basis.cols());
}

}  // namespace

Scores::Scores(const CameraEvidence& evidence, const Eigen::MatrixXd& directions, const Eigen::MatrixXd& places,
               bool with_scatter)
    : photographs_(evidence.score.size()), directions_(directions.cols()), formal_(evidence.formal) {
  const auto p = directions.rows(), n = static_cast<Eigen::Index>(photographs_);
  ScoreGroup group;
  group.values.resize(n, directions_);
  for (std::size_t i = 0; i < photographs_; ++i) {
    const Eigen::MatrixXd information = evidence.information[i].topLeftCorner(p, p);
    group.values.row(static_cast<Eigen::Index>(i)) = (directions.transpose() * evidence.score[i].head(p)).transpose();
    information_.emplace_back(information * directions);
    group.information.emplace_back(directions.transpose() * information_.back());
  }
  const Eigen::MatrixXd scatter =
      with_scatter ? common_scatter(group) : Eigen::MatrixXd::Zero(directions_, directions_).eval();
  left_.resize(n * directions_);
  for (std::size_t i = 0; i < photographs_; ++i) {
    const Eigen::MatrixXd& k = group.information[i];
    // A photograph that says nothing along a direction is not to be divided by.
    const Eigen::MatrixXd floor = 1e-9 * k.trace() * Eigen::MatrixXd::Identity(directions_, directions_);
    const Eigen::LLT<Eigen::MatrixXd> root(k + k * scatter * k + floor);
    own_.emplace_back(root.matrixL().solve(k));
    common_.emplace_back(root.matrixL().solve(information_[i].transpose()));
    left_.segment(static_cast<Eigen::Index>(i) * directions_, directions_) =
        root.matrixL().solve(group.values.row(static_cast<Eigen::Index>(i)).transpose());
  }
  Eigen::MatrixXd of_places(left_.size(), 0);
  for (Eigen::Index k = 0; k < places.cols(); ++k) {
    of_places.conservativeResize(Eigen::NoChange, of_places.cols() + directions_);
    of_places.rightCols(directions_) = response(places.col(k));
  }
  basis_ = orthonormal(Eigen::MatrixXd(left_.size(), 0), of_places, 1e-4);
  of_places_ = (basis_.transpose() * left_).squaredNorm();
  left_ -= basis_ * (basis_.transpose() * left_).eval();
}

Eigen::MatrixXd Scores::response(const Eigen::VectorXd& weights) const {
  // The common parameters follow those that differ.
  Eigen::MatrixXd moved = Eigen::MatrixXd::Zero(formal_.rows(), directions_);
  for (std::size_t i = 0; i < photographs_; ++i) moved += weights(static_cast<Eigen::Index>(i)) * information_[i];
  moved = (formal_ * moved).eval();
  Eigen::MatrixXd columns(left_.size(), directions_);
  for (std::size_t i = 0; i < photographs_; ++i)
    columns.middleRows(static_cast<Eigen::Index>(i) * directions_, directions_) =
        weights(static_cast<Eigen::Index>(i)) * own_[i] - common_[i] * moved;
  return columns;
}

Eigen::MatrixXd Scores::answer(const Eigen::VectorXd& weights) const {
  return orthonormal(basis_, response(weights), 0.05);
}

Eigen::VectorXd Scores::in_order(const std::vector<int>& order) const {
  Eigen::VectorXd ordered(left_.size());
  for (std::size_t i = 0; i < order.size(); ++i)
    ordered.segment(static_cast<Eigen::Index>(i) * directions_, directions_) =
        left_.segment(order[i] * directions_, directions_);
  const double left = ordered.squaredNorm() - (basis_.transpose() * ordered).squaredNorm();
  return ordered / std::sqrt(std::max(1e-300, left));
}

Eigen::VectorXd Scores::as_taken() const { return left_.normalized(); }

bool Scores::differ_by_place() const {
  const auto q = static_cast<double>(basis_.cols()), left = static_cast<double>(left_.size()) - q;
  return q > 0 && left > 0 && of_places_ / q > fisher_f_quantile(0.99, q, left) * left_.squaredNorm() / left;
}

double explained(const Eigen::VectorXd& scores, const Eigen::MatrixXd& answer) {
  return (answer.transpose() * scores).squaredNorm();
}

BestSplit best_split(const Scores& scores, const std::vector<Contrast>& contrasts, double highest) {
  BestSplit best;
  const Eigen::VectorXd given = scores.as_taken();
  std::vector<Eigen::MatrixXd> answers;
  for (std::size_t c = 0; c < contrasts.size(); ++c) {
    answers.push_back(scores.answer(contrasts[c].weights));
    if (answers.back().cols() == 0) continue;
    if (const double value = explained(given, answers.back()); value > best.explained)
      best.explained = value, best.contrast = c;
  }
  if (best.explained < 0) return best;
  std::vector<int> order(static_cast<std::size_t>(contrasts.front().weights.size()));
  std::iota(order.begin(), order.end(), 0);
  Random random(1, "order of photographs");
  int as_good = 0;
  for (int k = 0; k < permutations && as_good + 1 <= highest * (permutations + 1); ++k) {
    for (std::size_t i = order.size() - 1; i > 0; --i)
      std::swap(order[i], order[static_cast<std::size_t>(random.uniform() * static_cast<double>(i + 1))]);
    const Eigen::VectorXd drawn = scores.in_order(order);
    as_good += std::any_of(answers.begin(), answers.end(), [&](const Eigen::MatrixXd& each) {
      return explained(drawn, each) >= best.explained - as_good_as;
    });
  }
  best.level = (as_good + 1.0) / (permutations + 1.0);
  return best;
}

namespace {

/// Part of the scatter along the axis of largest scatter that the best cut of the sorted photographs explains, each
/// with its weight; `second` gets those above it.
double best_cut(const ScoreGroup& group, const Eigen::MatrixXd& places, std::vector<bool>* second) {
  const std::size_t n = group.information.size();
  const Eigen::Index d = group.values.cols();
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(d, d);
  for (const Eigen::MatrixXd& each : group.information) sum += each;
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> axes(group.values.transpose() * group.values, sum);
  if (axes.info() != Eigen::Success) return 0;
  const Eigen::VectorXd axis = axes.eigenvectors().col(d - 1);
  const auto rows = static_cast<Eigen::Index>(n);
  Eigen::VectorXd score = group.values * axis, weight(rows);
  for (std::size_t i = 0; i < n; ++i) weight(static_cast<Eigen::Index>(i)) = axis.dot(group.information[i] * axis);
  if (!(weight.minCoeff() > 0)) return 0;
  Eigen::MatrixXd design(rows, places.cols() + 1);
  design << Eigen::VectorXd::Ones(rows), places;
  const Eigen::MatrixXd normal = design.transpose() * weight.asDiagonal() * design;
  score -= weight.asDiagonal() * design * normal.ldlt().solve(design.transpose() * score);
  std::vector<std::size_t> order(n);
  std::iota(order.begin(), order.end(), std::size_t{0});
  const double total = score.sum(), weights = weight.sum(),
               spread = (score.array().square() / weight.array()).sum() - total * total / weights;
  const auto value = [&](std::size_t i) {
    return score(static_cast<Eigen::Index>(i)) / weight(static_cast<Eigen::Index>(i));
  };
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return value(a) < value(b); });
  double below = 0, weight_below = 0, best = 0;
  std::size_t cut = 0;
  for (std::size_t k = 0; k + smallest_part < n; ++k) {
    below += score(static_cast<Eigen::Index>(order[k])), weight_below += weight(static_cast<Eigen::Index>(order[k]));
    if (k + 1 < smallest_part) continue;
    const double above = total - below;
    const double between =
        below * below / weight_below + above * above / (weights - weight_below) - total * total / weights;
    if (between > best * spread) best = between / spread, cut = k + 1;
  }
  if (second) {
    second->assign(n, false);
    for (std::size_t k = cut; k < n; ++k) (*second)[order[k]] = true;
  }
  return best;
}

}  // namespace

std::optional<TwoGroups> two_groups(const CameraEvidence& evidence, const Eigen::MatrixXd& directions,
                                    const Eigen::MatrixXd& places, double highest) {
  const auto p = directions.rows(), d = directions.cols();
  ScoreGroup group;
  group.values.resize(static_cast<Eigen::Index>(evidence.score.size()), d);
  for (std::size_t i = 0; i < evidence.score.size(); ++i) {
    group.values.row(static_cast<Eigen::Index>(i)) = (directions.transpose() * evidence.score[i].head(p)).transpose();
    group.information.emplace_back(directions.transpose() * evidence.information[i].topLeftCorner(p, p) * directions);
  }
  TwoGroups result;
  const double found = best_cut(group, places, &result.second);
  if (!(found > 0)) return std::nullopt;
  const Eigen::MatrixXd common = common_scatter(group);
  std::vector<Eigen::MatrixXd> roots;
  for (const Eigen::MatrixXd& k : group.information) {
    const Eigen::LLT<Eigen::MatrixXd> root(k + k * common * k);
    if (root.info() != Eigen::Success) return std::nullopt;
    roots.emplace_back(root.matrixL());
  }
  Random random(1, "two groups");
  ScoreGroup drawn = group;
  int as_good = 0;
  for (int k = 0; k < permutations && as_good + 1 <= highest * (permutations + 1); ++k) {
    for (std::size_t i = 0; i < roots.size(); ++i) {
      Eigen::VectorXd unit(d);
      for (Eigen::Index j = 0; j < d; ++j) unit(j) = random.normal(1);
      drawn.values.row(static_cast<Eigen::Index>(i)) = (roots[i] * unit).transpose();
    }
    as_good += best_cut(drawn, places, nullptr) >= found - as_good_as;
  }
  result.level = (as_good + 1.0) / (permutations + 1.0);
  if (!(result.level <= highest)) return std::nullopt;
  if (2 * std::count(result.second.begin(), result.second.end(), true) > std::ssize(result.second))
    result.second.flip();
  return result;
}

}  // namespace plumbline::markers

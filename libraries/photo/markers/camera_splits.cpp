#include "photo/markers/camera_splits.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "geometry/linear_algebra/decompositions.hpp"
#include "plumbline/stop.hpp"

namespace plumbline::markers {
namespace {

using Split = CameraChange::Split;

constexpr std::size_t most_places = 60;  // to begin a part at, of long series

std::optional<Contrast> of_parts(Split split, const std::vector<bool>& second, double log_prior, int period = 0) {
  const auto count = static_cast<std::size_t>(std::count(second.begin(), second.end(), true));
  if (count < smallest_part || second.size() - count < smallest_part) return std::nullopt;
  Contrast contrast{split, Eigen::VectorXd::Zero(static_cast<Eigen::Index>(second.size())), {}, period, log_prior};
  for (std::size_t i = 0; i < second.size(); ++i)
    if (second[i]) contrast.weights(static_cast<Eigen::Index>(i)) = 1, contrast.second.push_back(static_cast<int>(i));
  return contrast;
}

double log_ways(std::size_t all, std::size_t part) {
  const double n = static_cast<double>(all), k = static_cast<double>(part);
  return std::lgamma(n + 1) - std::lgamma(k + 1) - std::lgamma(n - k + 1);
}

/// What each photograph says along the directions, and the sums of the first so many.
struct Along {
  std::vector<Eigen::VectorXd> score, score_up_to;
  std::vector<Eigen::MatrixXd> information, information_up_to;
  Eigen::MatrixXd prior;  ///< of the step: inverse covariance

  Along(const EffectFit& fit, const Eigen::MatrixXd& directions, const Eigen::VectorXd& sizes) {
    fit.own_scores(directions, score, information);
    const Eigen::Index k = directions.cols();
    prior = sizes.array().square().inverse().matrix().asDiagonal();
    score_up_to.emplace_back(Eigen::VectorXd::Zero(k)), information_up_to.emplace_back(Eigen::MatrixXd::Zero(k, k));
    for (std::size_t i = 0; i < score.size(); ++i)
      score_up_to.emplace_back(score_up_to.back() + score[i]),
          information_up_to.emplace_back(information_up_to.back() + information[i]);
  }

  /// Logarithm of the likelihood that a step of the photographs [first, behind) adds, at its best size.
  double gain(std::size_t first, std::size_t behind, const Eigen::MatrixXd& of_all) const {
    const Eigen::MatrixXd own = information_up_to[behind] - information_up_to[first];
    const Eigen::VectorXd right = score_up_to[behind] - score_up_to[first] - own * (of_all * score_up_to.back());
    const Eigen::MatrixXd left = own - own * of_all * own + prior;
    return 0.5 * right.dot(linear_algebra::solve_symmetric(left, right));
  }

  /// How much better each photograph fits the second part, of the parts as they are.
  std::vector<double> towards_second(const std::vector<bool>& second) const {
    const Eigen::Index k = prior.rows();
    Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(2 * k, 2 * k);
    Eigen::VectorXd right = Eigen::VectorXd::Zero(2 * k);
    normal.bottomRightCorner(k, k) = prior;
    for (std::size_t i = 0; i < score.size(); ++i) {
      normal.topLeftCorner(k, k) += information[i], right.head(k) += score[i];
      if (!second[i]) continue;
      normal.topRightCorner(k, k) += information[i], normal.bottomLeftCorner(k, k) += information[i];
      normal.bottomRightCorner(k, k) += information[i], right.tail(k) += score[i];
    }
    normal.diagonal().array() += 1e-9 * normal.diagonal().mean();
    const Eigen::VectorXd both = linear_algebra::solve_symmetric(normal, right);
    const Eigen::VectorXd first = both.head(k), step = both.tail(k);
    std::vector<double> better;
    for (std::size_t i = 0; i < score.size(); ++i)
      better.push_back(step.dot(score[i] - information[i] * first) - 0.5 * step.dot(information[i] * step));
    return better;
  }
};

/// The parts that are likeliest where each change from one to the other costs `price`.
std::vector<bool> likeliest_parts(const std::vector<double>& better, double price) {
  const std::size_t n = better.size();
  std::vector<std::array<bool, 2>> from_second(n);
  double first = 0, second = better[0];
  for (std::size_t i = 1; i < n; ++i) {
    from_second[i] = {second - price > first, second >= first - price};
    const double to_first = std::max(first, second - price), to_second = std::max(second, first - price);
    first = to_first, second = to_second + better[i];
  }
  std::vector<bool> parts(n);
  bool at = second > first;
  for (std::size_t i = n; i-- > 0;) parts[i] = at, at = i > 0 ? from_second[i][at] : at;
  return parts;
}

std::vector<bool> refined(const Along& along, std::vector<bool> second) {
  const double price = std::log(static_cast<double>(second.size()));
  for (int round = 0; round < 6; ++round) {
    std::vector<bool> next = likeliest_parts(along.towards_second(second), price);
    if (next == second) break;
    second = std::move(next);
  }
  return second;
}

std::size_t changes_of(const std::vector<bool>& second) {
  std::size_t changes = 0;
  for (std::size_t i = 1; i < second.size(); ++i) changes += second[i] != second[i - 1];
  return changes;
}

/// The likeliest window, and the likeliest cut.
std::vector<std::vector<bool>> likeliest_windows(const Along& along) {
  const std::size_t n = along.score.size(), stride = 1 + n / most_places;
  const Eigen::Index k = along.prior.rows();
  const Eigen::MatrixXd all = along.information_up_to.back();
  const Eigen::MatrixXd of_all = linear_algebra::solve_symmetric(
      all + 1e-9 * all.trace() * Eigen::MatrixXd::Identity(k, k), Eigen::MatrixXd::Identity(k, k));
  std::array<double, 2> best = {0, 0};
  std::array<std::pair<std::size_t, std::size_t>, 2> where;
  for (std::size_t first = 1; first < n; first += stride) {
    stop_point();
    for (std::size_t behind = std::min(n, first + smallest_part);; behind = std::min(n, behind + stride)) {
      const double gain = along.gain(first, behind, of_all);
      const std::size_t kind = behind == n;
      if (gain > best[kind]) best[kind] = gain, where[kind] = {first, behind};
      if (behind == n) break;
    }
  }
  std::vector<std::vector<bool>> windows;
  for (std::size_t kind = 0; kind < 2; ++kind) {
    if (!(best[kind] > 0)) continue;
    std::vector<bool> second(n);
    for (std::size_t i = where[kind].first; i < where[kind].second; ++i) second[i] = true;
    windows.push_back(second);
  }
  return windows;
}

}  // namespace

std::vector<Contrast> contrasts_in_order(std::size_t n) {
  std::vector<Contrast> contrasts;
  const std::size_t stride = 1 + n / most_places;
  const double cuts = static_cast<double>((n - 2 * smallest_part) / stride + 1);
  for (std::size_t cut = smallest_part; cut + smallest_part <= n; cut += stride) {
    std::vector<bool> second(n);
    std::fill(second.begin() + static_cast<std::ptrdiff_t>(cut), second.end(), true);
    if (auto one = of_parts(Split::from_on, second, std::log(0.4 / cuts))) contrasts.push_back(*one);
  }
  Contrast drift{
      Split::drift, Eigen::VectorXd::LinSpaced(static_cast<Eigen::Index>(n), -0.5, 0.5), {}, 0, std::log(0.15)};
  for (std::size_t i = n / 2; i < n; ++i) drift.second.push_back(static_cast<int>(i));
  contrasts.push_back(drift);
  for (const std::size_t period : {2, 3, 4})
    for (std::size_t first = 0; first < (period == 2 ? 1 : period); ++first) {
      std::vector<bool> second(n);
      for (std::size_t i = first; i < n; i += period) second[i] = true;
      if (auto one = of_parts(Split::every, second, std::log(0.15 / 8), static_cast<int>(period)))
        contrasts.push_back(*one);
    }
  return contrasts;
}

std::optional<Contrast> upside_down(const std::vector<RigidTransform>& poses) {
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
  return of_parts(Split::upside_down, turned, std::log(0.1));
}

std::vector<Contrast> groups(const EffectFit& fit, const Eigen::MatrixXd& directions) {
  Eigen::MatrixXd steps;
  Eigen::VectorXd weight;
  fit.own_steps(directions, steps, weight);
  if (!steps.allFinite() || !(weight.sum() > 0)) return {};
  const Eigen::RowVectorXd mean = weight.transpose() * steps / weight.sum();
  const Eigen::MatrixXd centred = weight.cwiseMax(0).cwiseSqrt().asDiagonal() * (steps.rowwise() - mean);
  const linear_algebra::SingularValues svd(centred, Eigen::ComputeThinV);
  const Eigen::VectorXd value = steps * svd.matrixV().col(0);
  const auto n = static_cast<std::size_t>(value.size());
  std::vector<int> order(n);
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return value(a) < value(b); });
  std::vector<Contrast> contrasts;
  for (std::size_t cut = smallest_part; cut + smallest_part <= n; ++cut) {
    std::vector<bool> second(n);
    const bool above = 2 * cut >= n;  // the smaller part is the second
    for (std::size_t k = above ? cut : 0; k < (above ? n : cut); ++k) second[order[k]] = true;
    const double log_prior = std::log(0.1 / static_cast<double>(n)) - log_ways(n, above ? n - cut : cut);
    if (auto one = of_parts(Split::some, second, log_prior)) contrasts.push_back(*one);
  }
  return contrasts;
}

std::vector<Contrast> stretches(const EffectFit& fit, const Eigen::MatrixXd& directions, const Eigen::VectorXd& sizes) {
  const Along along(fit, directions, sizes);
  std::vector<std::vector<bool>> tried = likeliest_windows(along);
  for (std::size_t k = 0, before = tried.size(); k < before; ++k) tried.push_back(refined(along, tried[k]));
  std::vector<Contrast> contrasts;
  for (std::size_t k = 0; k < tried.size(); ++k) {
    std::vector<bool>& second = tried[k];
    if (std::find(tried.begin(), tried.begin() + static_cast<std::ptrdiff_t>(k), second) !=
        tried.begin() + static_cast<std::ptrdiff_t>(k))
      continue;
    if (second.front()) second.flip();
    const std::size_t changes = changes_of(second), n = second.size();
    if (changes < 2) continue;
    // Parts that change more often have no order.
    constexpr std::size_t most_changes = 6;
    const bool in_order = changes <= most_changes;
    const double log_prior =
        in_order ? std::log(0.1) - static_cast<double>(changes - 1) * std::log(2) - log_ways(n - 1, changes)
                 : std::log(0.1 / static_cast<double>(n)) -
                       log_ways(n, static_cast<std::size_t>(std::count(second.begin(), second.end(), true)));
    if (auto one = of_parts(in_order ? Split::stretches : Split::some, second, log_prior)) contrasts.push_back(*one);
  }
  return contrasts;
}

std::pair<Eigen::VectorXd, Eigen::VectorXd> along_their_axis(const EffectFit& fit, const Eigen::MatrixXd& directions) {
  Eigen::MatrixXd steps;
  Eigen::VectorXd information;
  std::vector<Eigen::VectorXd> scores;
  std::vector<Eigen::MatrixXd> own;
  fit.own_steps(directions, steps, information), fit.own_scores(directions, scores, own);
  if (!(information.minCoeff() > 0) || !steps.allFinite()) return {};
  const Eigen::RowVectorXd mean = information.transpose() * steps / information.sum();
  const Eigen::MatrixXd centred = information.cwiseSqrt().asDiagonal() * (steps.rowwise() - mean);
  const Eigen::VectorXd axis =
      linear_algebra::SymmetricEigen(centred.transpose() * centred).eigenvectors().rightCols<1>();
  Eigen::VectorXd sigmas(steps.rows());
  for (Eigen::Index i = 0; i < steps.rows(); ++i)
    sigmas(i) = std::sqrt(axis.dot(linear_algebra::solve_symmetric(own[static_cast<std::size_t>(i)], axis)));
  return {steps * axis, sigmas};
}

std::vector<std::pair<int, int>> runs_of(const std::vector<int>& second) {
  std::vector<std::pair<int, int>> runs;
  for (const int at : second)
    if (!runs.empty() && at == runs.back().second + 1)
      runs.back().second = at;
    else
      runs.emplace_back(at, at);
  return runs;
}

}  // namespace plumbline::markers

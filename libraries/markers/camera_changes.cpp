#include "markers/camera_changes.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "geometry/random.hpp"

namespace plumbline::markers {
namespace {

using Split = CameraChange::Split;
using What = CameraChange::What;

constexpr int fewest_photographs = 8, smallest_part = 3;
constexpr int permutations = 1999;
constexpr double level_of_groups = 0.002, level_of_all = 0.004;

/// Part of sound sets of photographs that may be told to change in this: with the two below 2 % in all.
double highest_level(What what) {
  switch (what) {
    case What::focus:
    case What::principal_point:
      return 0.005;
    case What::distortion:
      return 0.003;
    case What::aspect:
      break;
  }
  return 0.001;
}

/// A way to weigh the photographs against each other: of two parts, or of a drift. The weights sum up to zero.
struct Contrast {
  Split split = Split::from_on;
  Eigen::VectorXd weights;  // second part positive
  std::vector<int> second;
  int period = 0;
};

/// What may differ: directions in the parameters of the evidence.
struct Hypothesis {
  What what = What::focus;
  Eigen::MatrixXd directions;
};

Contrast of_parts(Split split, const std::vector<bool>& second, int period = 0) {
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

/// By the order of the photographs.
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

/// The camera's x axis in the object: held one way or upside down against most. A principal point shows it when a
/// program has turned the pictures; a lens or a board that are not quite the model show it, too, but in other
/// parameters.
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

std::vector<Hypothesis> hypotheses_of(const CameraEvidence& evidence, const BrownCamera& camera) {
  const auto values = camera.parameters();
  const auto p = static_cast<Eigen::Index>(evidence.parameters.size());
  std::vector<Hypothesis> hypotheses;
  const auto add = [&](What what, const std::vector<std::vector<std::pair<int, double>>>& columns) {
    std::vector<Eigen::VectorXd> directions;
    for (const auto& column : columns) {
      Eigen::VectorXd direction = Eigen::VectorXd::Zero(p);
      for (const auto& [parameter, value] : column) {
        const auto at = std::find(evidence.parameters.begin(), evidence.parameters.end(), parameter);
        if (at != evidence.parameters.end()) direction(at - evidence.parameters.begin()) = value;
      }
      if (!direction.isZero(0)) directions.push_back(direction);
    }
    if (directions.empty()) return;
    Hypothesis hypothesis;
    hypothesis.what = what;
    hypothesis.directions.resize(p, static_cast<Eigen::Index>(directions.size()));
    for (std::size_t k = 0; k < directions.size(); ++k)
      hypothesis.directions.col(static_cast<Eigen::Index>(k)) = directions[k];
    hypotheses.push_back(hypothesis);
  };
  add(What::focus, {{{0, values[0]}, {1, values[1]}}});
  add(What::aspect, {{{0, 0.5 * values[0]}, {1, -0.5 * values[1]}}});
  add(What::principal_point, {{{2, 1.0}}, {{3, 1.0}}});
  add(What::distortion, {{{4, 1.0}}, {{5, 1.0}}});
  return hypotheses;
}

/// Scores of the photographs along a hypothesis, one a row, with the inverse of their scatter.
struct Scores {
  Eigen::MatrixXd values;
  Eigen::MatrixXd weight;
};

Scores scores_of(const CameraEvidence& evidence, const Hypothesis& hypothesis) {
  const auto n = static_cast<Eigen::Index>(evidence.score.size());
  Scores scores;
  scores.values.resize(n, hypothesis.directions.cols());
  for (Eigen::Index i = 0; i < n; ++i)
    scores.values.row(i) = (hypothesis.directions.transpose() *
                            evidence.score[static_cast<std::size_t>(i)].head(hypothesis.directions.rows()))
                               .transpose();
  scores.values.rowwise() -= scores.values.colwise().mean().eval();
  const Eigen::MatrixXd scatter = scores.values.transpose() * scores.values;
  scores.weight = scatter.ldlt().solve(Eigen::MatrixXd::Identity(scatter.rows(), scatter.cols()));
  return scores;
}

/// n log of what the split leaves unexplained of the scatter, less what as many free parameters explain of nothing
/// (Schwarz 1978): larger is better.
double merit(const Scores& scores, const Contrast& contrast, const std::vector<int>& order) {
  const auto n = static_cast<double>(order.size());
  Eigen::RowVectorXd sum = Eigen::RowVectorXd::Zero(scores.values.cols());
  for (std::size_t i = 0; i < order.size(); ++i)
    sum += contrast.weights(static_cast<Eigen::Index>(i)) * scores.values.row(order[i]);
  const double explained = (sum * scores.weight * sum.transpose())(0, 0) / contrast.weights.squaredNorm();
  return -n * std::log(std::max(1e-12, 1 - explained)) - static_cast<double>(scores.values.cols()) * std::log(n);
}

/// How much the parts differ along the hypothesis, the other parameters common.
Eigen::VectorXd difference(const CameraEvidence& evidence, const Hypothesis& hypothesis, const Contrast& contrast) {
  const auto p = hypothesis.directions.rows();
  Eigen::VectorXd score = Eigen::VectorXd::Zero(p);
  Eigen::MatrixXd once = Eigen::MatrixXd::Zero(p, p), twice = once;
  for (std::size_t i = 0; i < evidence.score.size(); ++i) {
    const double w = contrast.weights(static_cast<Eigen::Index>(i));
    score += w * evidence.score[i].head(p);
    once += w * evidence.information[i].topLeftCorner(p, p),
        twice += w * w * evidence.information[i].topLeftCorner(p, p);
  }
  const Eigen::MatrixXd left = twice - once * evidence.formal * once;
  const Eigen::MatrixXd& e = hypothesis.directions;
  return (e.transpose() * left * e).ldlt().solve(e.transpose() * score);
}

/// Principal distances of single photographs in two groups: the best split of their sorted values, and how often
/// normal ones of the same uncertainties are split as well.
std::optional<CameraChange> two_groups(const CameraEvidence& evidence, const Hypothesis& focus) {
  const std::size_t n = evidence.score.size();
  std::vector<double> value(n), variance(n);
  for (std::size_t i = 0; i < n; ++i) {
    const auto p = focus.directions.rows();
    const double information =
        (focus.directions.transpose() * evidence.information[i].topLeftCorner(p, p) * focus.directions)(0, 0);
    if (!(information > 0)) return std::nullopt;
    value[i] = focus.directions.col(0).dot(evidence.score[i].head(p)) / information, variance[i] = 1 / information;
  }
  // The scatter within a group is not known beforehand: the formal one, and the same for all beside it.
  const auto merit_of = [&](const std::vector<double>& values, std::vector<bool>* second) {
    std::vector<std::size_t> order(n);
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return values[a] < values[b]; });
    double total = 0, square = 0, weights = 0;
    for (std::size_t i = 0; i < n; ++i)
      total += values[i] / variance[i], square += values[i] * values[i] / variance[i], weights += 1 / variance[i];
    const double spread = square - total * total / weights;
    double below = 0, weight_below = 0, best = 0;
    std::size_t cut = 0;
    for (std::size_t k = 0; k + smallest_part < n; ++k) {
      below += values[order[k]] / variance[order[k]], weight_below += 1 / variance[order[k]];
      if (k + 1 < smallest_part) continue;
      const double above = total - below;
      const double between =
          below * below / weight_below + above * above / (weights - weight_below) - total * total / weights;
      if (between / spread > best) best = between / spread, cut = k + 1;
    }
    if (second) {
      second->assign(n, false);
      for (std::size_t k = cut; k < n; ++k) (*second)[order[k]] = true;
    }
    return best;
  };
  std::vector<bool> second;
  const double found = merit_of(value, &second);
  double mean = 0, weights = 0, excess = 0;
  for (std::size_t i = 0; i < n; ++i) mean += value[i] / variance[i], weights += 1 / variance[i];
  mean /= weights;
  for (std::size_t i = 0; i < n; ++i) excess += (value[i] - mean) * (value[i] - mean) / variance[i];
  double inverse = 0;
  for (std::size_t i = 0; i < n; ++i) inverse += 1 / variance[i] / variance[i];
  const double common =
      std::max(0.0, (excess - static_cast<double>(n - 1)) / (weights - inverse / weights));  // DerSimonian, Laird 1986
  Random random(1, "two groups");
  int as_good = 0;
  for (int k = 0; k < permutations; ++k) {
    std::vector<double> drawn(n);
    for (std::size_t i = 0; i < n; ++i) drawn[i] = random.normal(std::sqrt(variance[i] + common));
    as_good += merit_of(drawn, nullptr) >= found;
  }
  CameraChange change;
  change.level = (as_good + 1.0) / (permutations + 1.0);
  if (!(change.level <= level_of_groups)) return std::nullopt;
  if (2 * std::count(second.begin(), second.end(), true) > static_cast<std::ptrdiff_t>(n)) second.flip();
  const Contrast contrast = of_parts(Split::some, second);
  change.split = Split::some, change.what = What::focus, change.second = contrast.second;
  change.by.x() = difference(evidence, focus, contrast)(0);
  return change;
}

/// How far the sum of squares falls if the parts have a camera each along `directions`, in units of the variance.
double decrease(const CameraEvidence& evidence, const Eigen::MatrixXd& directions, const Contrast& contrast,
                const std::vector<int>& order) {
  const auto p = directions.rows();
  Eigen::VectorXd score = Eigen::VectorXd::Zero(p);
  Eigen::MatrixXd once = Eigen::MatrixXd::Zero(p, p), twice = once;
  for (std::size_t i = 0; i < order.size(); ++i) {
    const auto at = static_cast<std::size_t>(order[i]);
    const double w = contrast.weights(static_cast<Eigen::Index>(i));
    score += w * evidence.score[at].head(p);
    once += w * evidence.information[at].topLeftCorner(p, p);
    twice += w * w * evidence.information[at].topLeftCorner(p, p);
  }
  const Eigen::MatrixXd left = directions.transpose() * (twice - once * evidence.formal * once) * directions;
  const Eigen::LDLT<Eigen::MatrixXd> factor(left);
  const Eigen::VectorXd along = directions.transpose() * score;
  return factor.isPositive() ? along.dot(factor.solve(along)) : 0;
}

/// The best split by one hypothesis, and how many orders of the photographs split as well.
struct BestSplit {
  std::size_t contrast = 0;
  double merit = 0, level = 1;
};

/// `merit_of` a contrast with the photographs in some order: larger is better.
template <typename Merit>
BestSplit best_split(std::size_t photographs, const std::vector<Contrast>& contrasts, double highest,
                     const Merit& merit_of) {
  std::vector<int> order(photographs);
  std::iota(order.begin(), order.end(), 0);
  BestSplit best;
  best.merit = -1e300;
  for (std::size_t c = 0; c < contrasts.size(); ++c) {
    const double value = merit_of(contrasts[c], order);
    if (value > best.merit) best.merit = value, best.contrast = c;
  }
  Random random(1, "order of photographs");
  int as_good = 0;
  for (int k = 0; k < permutations && as_good + 1 <= highest * (permutations + 1); ++k) {
    for (std::size_t i = order.size() - 1; i > 0; --i)
      std::swap(order[i], order[static_cast<std::size_t>(random.uniform() * static_cast<double>(i + 1))]);
    as_good += std::any_of(contrasts.begin(), contrasts.end(),
                           [&](const Contrast& each) { return merit_of(each, order) >= best.merit; });
  }
  best.level = (as_good + 1.0) / (permutations + 1.0);
  return best;
}

CameraChange described(const CameraEvidence& evidence, const Hypothesis& hypothesis, const Contrast& contrast,
                       double level) {
  CameraChange change{contrast.split, hypothesis.what, contrast.second, contrast.period, {0, 0}, level};
  const Eigen::VectorXd by = difference(evidence, hypothesis, contrast);
  change.by.head(std::min<Eigen::Index>(2, by.size())) = by.head(std::min<Eigen::Index>(2, by.size()));
  return change;
}

/// A program takes the distortion away, another lens has another one; a part of it that comes and goes while the
/// principal distance stays is what the lens, the board or the places of the photographs have beside the model.
bool is_plausible(const CameraChange& change, const BrownCamera& camera) {
  return change.what != What::distortion || std::abs(change.by.x()) > 0.5 * std::abs(camera.k1);
}

/// Parts that differ in all parameters together, such as pictures that a program freed of distortion: by how far the
/// sum of squares falls. What differs most names it.
std::optional<CameraChange> change_of_all(const CameraEvidence& evidence, const std::vector<Contrast>& contrasts,
                                          const std::vector<Hypothesis>& hypotheses, const BrownCamera& camera) {
  const auto p = static_cast<Eigen::Index>(evidence.parameters.size());
  const Eigen::MatrixXd all = Eigen::MatrixXd::Identity(p, p);
  const BestSplit best =
      best_split(evidence.score.size(), contrasts, level_of_all,
                 [&](const Contrast& contrast, const auto& order) { return decrease(evidence, all, contrast, order); });
  if (!(best.level <= level_of_all)) return std::nullopt;
  std::vector<int> order(evidence.score.size());
  std::iota(order.begin(), order.end(), 0);
  const Contrast& contrast = contrasts[best.contrast];
  const auto named = std::max_element(hypotheses.begin(), hypotheses.end(), [&](const auto& a, const auto& b) {
    return decrease(evidence, a.directions, contrast, order) < decrease(evidence, b.directions, contrast, order);
  });
  if (named == hypotheses.end()) return std::nullopt;
  const CameraChange change = described(evidence, *named, contrast, best.level);
  return is_plausible(change, camera) ? std::optional(change) : std::nullopt;
}

}  // namespace

std::optional<CameraChange> find_change(const CameraEvidence& given, const BrownCamera& camera,
                                        const std::vector<RigidTransform>& cam_from_object) {
  constexpr double significant = 5;  // logarithm of a likelihood ratio
  const std::size_t n = given.score.size();
  if (n < fewest_photographs || cam_from_object.size() != n) return std::nullopt;
  // A principal point that moves and rows that move are hardly to be told apart, the others are.
  const Scatter rows = rolling_shutter_of(given, camera);
  const CameraEvidence reduced = rows.gain > significant ? without_rolling_shutter(given, rows.rms) : given;
  const std::vector<Contrast> in_order = contrasts_in_order(n);
  std::vector<Contrast> with_turned = in_order;
  add_upside_down(cam_from_object, with_turned);
  std::optional<CameraChange> change;
  double clearest = 1, largest = 0;  // level over the highest, merit
  for (const Hypothesis& hypothesis : hypotheses_of(given, camera)) {
    const bool of_point = hypothesis.what == What::principal_point;
    const CameraEvidence& evidence = of_point ? given : reduced;
    const std::vector<Contrast>& contrasts = of_point ? with_turned : in_order;
    const double highest = highest_level(hypothesis.what);
    const Scores scores = scores_of(evidence, hypothesis);
    const BestSplit best = best_split(n, contrasts, highest, [&](const Contrast& contrast, const auto& order) {
      return merit(scores, contrast, order);
    });
    const double clear = best.level / highest;
    if (clear > 1 || clear > clearest || (clear == clearest && best.merit < largest)) continue;
    const CameraChange found = described(evidence, hypothesis, contrasts[best.contrast], best.level);
    if (!is_plausible(found, camera)) continue;
    clearest = clear, largest = best.merit, change = found;
  }
  if (change) return change;
  if ((change = change_of_all(reduced, in_order, hypotheses_of(given, camera), camera))) return change;
  // Two principal distances look like moving rows as well, but less so than like a focus that moves.
  const bool moves = explain_scatter(given, camera).kind == Scatter::Kind::focus;
  for (const Hypothesis& hypothesis : hypotheses_of(given, camera))
    if (hypothesis.what == What::focus) return two_groups(moves ? given : reduced, hypothesis);
  return std::nullopt;
}

bool divides(const CameraChange& change) { return change.split != Split::drift; }

CameraTruth judge_camera(CameraEvidence evidence, const BrownCamera& camera,
                         const std::vector<RigidTransform>& cam_from_object) {
  CameraTruth truth;
  truth.evidence = std::move(evidence);
  truth.empirical = empirical_covariance(truth.evidence);
  truth.scatter = explain_scatter(truth.evidence, camera);
  truth.change = find_change(truth.evidence, camera, cam_from_object);
  return truth;
}

}  // namespace plumbline::markers

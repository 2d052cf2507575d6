#include "markers/camera_changes.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/median.hpp"
#include "markers/camera_splits.hpp"

namespace plumbline::markers {
namespace {

using Split = CameraChange::Split;
using What = CameraChange::What;

constexpr double level_of_all = 0.002, level_of_groups = 0.001;

/// Part of sound sets of photographs that may be told to change in this: with the two above 1 % in all. Chosen on
/// simulated photographs, of which 2 % are told to, as what no place explains is not quite alike in all of them.
double highest_level(What what) {
  switch (what) {
    case What::focus:
    case What::principal_point:
      return 0.0025;
    case What::distortion:
      return 0.0015;
    case What::aspect:
      break;
  }
  return 0.0005;
}

/// What may differ: directions in the parameters of the evidence.
struct Hypothesis {
  What what = What::focus;
  Eigen::MatrixXd directions;
};

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

/// A change with what it explains.
struct Candidate {
  CameraChange change;
  double merit = 0;
};

/// By how much the sum of squares of all scores falls if the parts have parameters of their own along the hypothesis, in
/// units of the photographs' scatter, less what as many parameters explain of nothing (Schwarz 1978) and what the best
/// of as many ways to split does (`log_ways`): one measure for all changes.
double merit(const CameraEvidence& evidence, const Hypothesis& hypothesis, const Contrast& contrast, double log_ways) {
  const auto p = hypothesis.directions.rows();
  const auto n = static_cast<double>(evidence.score.size());
  Eigen::VectorXd score = Eigen::VectorXd::Zero(p);
  Eigen::MatrixXd once = Eigen::MatrixXd::Zero(p, p), twice = once;
  double scatter = 0;
  for (std::size_t i = 0; i < evidence.score.size(); ++i) {
    const double w = contrast.weights(static_cast<Eigen::Index>(i));
    const Eigen::MatrixXd information = evidence.information[i].topLeftCorner(p, p);
    score += w * evidence.score[i].head(p);
    once += w * information, twice += w * w * information;
    scatter += n / (n - 1) * evidence.score[i].head(p).dot(evidence.formal * evidence.score[i].head(p));
  }
  const Eigen::MatrixXd& e = hypothesis.directions;
  const Eigen::LDLT<Eigen::MatrixXd> factor(e.transpose() * (twice - once * evidence.formal * once) * e);
  if (!factor.isPositive()) return -std::numeric_limits<double>::infinity();
  const Eigen::VectorXd along = e.transpose() * score;
  return along.dot(factor.solve(along)) / std::max(1.0, scatter / static_cast<double>(p)) -
         static_cast<double>(e.cols()) * std::log(n) - 2 * log_ways;
}

/// What of the hypotheses the split explains best, named.
Candidate named(const CameraEvidence& evidence, const std::vector<Hypothesis>& hypotheses, const Contrast& contrast,
                double level, double log_ways) {
  Candidate best;
  const Hypothesis* of = nullptr;
  for (const Hypothesis& hypothesis : hypotheses) {
    const double value = merit(evidence, hypothesis, contrast, log_ways);
    if (!of || value > best.merit) of = &hypothesis, best.merit = value;
  }
  best.change = described(evidence, *of, contrast, level);
  return best;
}

/// Parts that differ in all parameters together, such as pictures that a program freed of distortion: by how far the
/// sum of squares falls. What differs most names it.
std::optional<Candidate> change_of_all(const CameraEvidence& evidence, const std::vector<Contrast>& contrasts,
                                       const std::vector<Hypothesis>& hypotheses, const Eigen::MatrixXd& places,
                                       const BrownCamera& camera) {
  const auto p = static_cast<Eigen::Index>(evidence.parameters.size());
  const Scores scores(evidence, Eigen::MatrixXd::Identity(p, p), places, false);
  const BestSplit best = best_split(scores, contrasts, level_of_all);
  if (!(best.level <= level_of_all) || hypotheses.empty()) return std::nullopt;
  const Candidate found = named(evidence, hypotheses, contrasts[best.contrast], best.level,
                                std::log(static_cast<double>(contrasts.size())));
  return is_plausible(found.change, camera) ? std::optional(found) : std::nullopt;
}

/// The clearest of the hypotheses' best splits.
std::optional<Candidate> change_in_order(const CameraEvidence& given, const CameraEvidence& reduced,
                                         const std::vector<Hypothesis>& hypotheses,
                                         const std::vector<Contrast>& contrasts, const Eigen::MatrixXd& places,
                                         const BrownCamera& camera) {
  std::optional<Candidate> clearest;
  double least = 1;  // level over the highest
  for (const Hypothesis& hypothesis : hypotheses) {
    // A principal point that moves and rows that move are hardly to be told apart, the others are.
    const CameraEvidence& evidence = hypothesis.what == What::principal_point ? given : reduced;
    const Scores scores(evidence, hypothesis.directions, places);
    const BestSplit best = best_split(scores, contrasts, highest_level(hypothesis.what));
    const double clear = best.level / highest_level(hypothesis.what);
    if (best.explained < 0 || clear > least) continue;
    Candidate found;
    found.merit = merit(reduced, hypothesis, contrasts[best.contrast], std::log(static_cast<double>(contrasts.size())));
    if (clearest && clear == least && found.merit < clearest->merit) continue;
    found.change = described(evidence, hypothesis, contrasts[best.contrast], best.level);
    if (!is_plausible(found.change, camera)) continue;
    least = clear, clearest = found;
  }
  return clearest;
}

/// Single photographs in two groups by their principal distance, their principal point or both: another body, in no
/// order. `named_in`: what the change is measured in.
std::optional<Candidate> change_of_groups(const CameraEvidence& evidence, const CameraEvidence& named_in,
                                          const std::vector<Hypothesis>& hypotheses, const Eigen::MatrixXd& places,
                                          const BrownCamera& camera) {
  std::vector<Eigen::MatrixXd> tried;
  for (const Hypothesis& hypothesis : hypotheses)
    if (hypothesis.what == What::focus || hypothesis.what == What::principal_point)
      tried.push_back(hypothesis.directions);
  if (tried.size() == 2) {
    Eigen::MatrixXd both(tried[0].rows(), tried[0].cols() + tried[1].cols());
    both << tried[0], tried[1];
    tried.push_back(both);
  }
  std::optional<Candidate> best;
  for (const Eigen::MatrixXd& directions : tried) {
    const bool by_place = Scores(evidence, directions, places).differ_by_place();
    const auto groups = two_groups(evidence, directions, by_place ? places : places.leftCols(0), level_of_groups);
    if (!groups) continue;
    const Contrast contrast = of_parts(Split::some, groups->second);
    const auto n = static_cast<double>(groups->second.size()), k = static_cast<double>(contrast.second.size());
    const double log_ways = std::lgamma(n + 1) - std::lgamma(k + 1) - std::lgamma(n - k + 1);
    const Candidate found = named(named_in, hypotheses, contrast, groups->level, log_ways);
    if (is_plausible(found.change, camera) && (!best || found.merit > best->merit)) best = found;
  }
  return best;
}

/// Whether the photographs on either side of the middle of some place differ as much as those of the change.
bool explained_by_place(const CameraEvidence& evidence, const Hypothesis& hypothesis, const CameraChange& change,
                        const Places& places) {
  if (change.split == Split::upside_down) return true;
  const auto n = static_cast<Eigen::Index>(evidence.score.size());
  const Scores scores(evidence, hypothesis.directions, Eigen::MatrixXd(n, 0));
  const auto explains = [&](const Contrast& contrast) {
    return explained(scores.as_taken(), scores.answer(contrast.weights));
  };
  std::vector<Contrast> by_place;
  for (const Eigen::MatrixXd* place : {&places.tilt, &places.roll, &places.distance})
    for (Eigen::Index k = 0; k < place->cols(); ++k) {
      const Eigen::VectorXd column = place->col(k);
      const double middle = upper_median({column.data(), column.data() + n});
      std::vector<bool> second;
      for (const double value : column) second.push_back(value >= middle);
      add_parts(Split::some, second, 0, by_place);
    }
  std::vector<bool> second(evidence.score.size());
  for (const int k : change.second) second[static_cast<std::size_t>(k)] = true;
  const double own = explains(of_parts(change.split, second));
  return std::any_of(by_place.begin(), by_place.end(),
                     [&](const Contrast& each) { return explains(each) >= own - as_good_as; });
}

}  // namespace

std::optional<CameraChange> find_change(const CameraEvidence& given, const BrownCamera& camera,
                                        const std::vector<RigidTransform>& cam_from_object,
                                        const std::vector<Scatter>& causes) {
  const std::size_t n = given.score.size();
  if (n < fewest_to_compare || cam_from_object.size() != n || given.parameters.empty()) return std::nullopt;
  const double rows = rms_of(causes, Scatter::Kind::rolling_shutter);
  const CameraEvidence reduced = rows > 0 ? without_rolling_shutter(given, rows) : given;
  const std::vector<Hypothesis> hypotheses = hypotheses_of(given, camera);
  const Places places = places_of(cam_from_object);
  const Eigen::MatrixXd columns = columns_of({places.tilt, places.roll, places.distance}, n);
  const std::vector<Contrast> contrasts = contrasts_in_order(n);
  std::optional<Candidate> found = change_in_order(given, reduced, hypotheses, contrasts, columns, camera);
  if (!found) {
    // Pictures that a program turned: the roll is what they have in common, so it is not taken out.
    std::vector<Contrast> turned;
    add_upside_down(cam_from_object, turned);
    const Eigen::MatrixXd without_roll = columns_of({places.tilt, places.distance}, n);
    std::vector<Hypothesis> of_point = hypotheses;
    std::erase_if(of_point, [](const Hypothesis& each) { return each.what != What::principal_point; });
    found = change_in_order(given, reduced, of_point, turned, without_roll, camera);
  }
  if (!found) found = change_of_all(reduced, contrasts, hypotheses, columns, camera);
  std::vector<const CameraEvidence*> evidences{&reduced};
  if (rows > 0) evidences.push_back(&given);
  for (const CameraEvidence* evidence : evidences)
    if (const auto groups =
            change_of_groups(about_common(*evidence, camera, causes), reduced, hypotheses, columns, camera))
      if (!found || groups->merit > found->merit) found = groups;
  if (!found) return std::nullopt;
  for (const Hypothesis& hypothesis : hypotheses) {
    if (hypothesis.what != found->change.what) continue;
    const CameraEvidence& evidence = hypothesis.what == What::principal_point ? given : reduced;
    found->change.or_place = explained_by_place(evidence, hypothesis, found->change, places);
  }
  return found->change;
}

bool divides(const CameraChange& change) { return change.split != Split::drift; }

CameraTruth judge_camera(CameraEvidence evidence, const BrownCamera& camera,
                         const std::vector<RigidTransform>& cam_from_object) {
  CameraTruth truth;
  truth.evidence = std::move(evidence);
  truth.empirical = empirical_covariance(truth.evidence);
  truth.scatter = explain_scatter(truth.evidence, camera);
  truth.change = find_change(truth.evidence, camera, cam_from_object, truth.scatter);
  return truth;
}

}  // namespace plumbline::markers

#include "photo/markers/camera_changes.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "geometry/linear_algebra/decompositions.hpp"
#include "photo/markers/camera_splits.hpp"
#include "photo/markers/two_groups.hpp"
#include "plumbline/stop.hpp"

namespace plumbline::markers {
namespace {

using Split = CameraChange::Split;
using What = CameraChange::What;

constexpr std::size_t fewest_photographs = 8;
constexpr double told_from = 5;  // logarithm of the odds, 150 to 1
constexpr double told_of_place_from = 8, mostly = 0.9;
constexpr double clear_from = 0.9;  // probability of a split, of a cause
constexpr double significant = 5;   // logarithm of a likelihood ratio

bool can_be_compared(const CameraEvidence& evidence, const std::vector<RigidTransform>& cam_from_object) {
  return evidence.score.size() >= fewest_photographs && cam_from_object.size() == evidence.score.size() &&
         !evidence.parameters.empty();
}

/// What may differ, and by how much it usually would.
struct Hypothesis {
  What what = What::focus;
  Eigen::MatrixXd directions;
  Eigen::VectorXd sizes;
};

std::vector<Hypothesis> hypotheses_of(const EffectModel& model, const BrownCamera& c) {
  const double w = c.width;
  std::vector<Hypothesis> all;
  const auto add = [&](What what, const std::vector<std::array<double, 9>>& columns, const std::vector<double>& sizes) {
    Hypothesis one{what, Eigen::MatrixXd(), Eigen::Map<const Eigen::VectorXd>(sizes.data(), std::ssize(sizes))};
    for (const auto& column : columns) {
      const Eigen::VectorXd direction = model.direction(column);
      if (direction.isZero(0)) return;
      one.directions.conservativeResize(direction.size(), one.directions.cols() + 1);
      one.directions.rightCols(1) = direction;
    }
    all.push_back(one);
  };
  add(What::focus, {{c.fx, c.fy}}, {0.03});
  add(What::aspect, {{0.5 * c.fx, -0.5 * c.fy}}, {0.03});
  add(What::principal_point, {{0, 0, 1}, {0, 0, 0, 1}}, {0.01 * w, 0.01 * w});
  add(What::distortion, {{0, 0, 0, 0, 1}, {0, 0, 0, 0, 0, 1}}, {0.1, 0.3});
  add(What::several, {{c.fx, c.fy}, {0, 0, 1}, {0, 0, 0, 1}, {0, 0, 0, 0, 1}, {0, 0, 0, 0, 0, 1}},
      {0.03, 0.01 * w, 0.01 * w, 0.1, 0.3});
  // Of the distortion that all have in the mean: those that a program freed of it lack more than that.
  if (c.lens == LensModel::brown) add(What::undistorted, {{0, 0, 0, 0, -c.k1, -c.k2, -c.k3, -c.p1, -c.p2}}, {1.5});
  // Turned about the middle of the image, what is decentred changes its side, too.
  const std::array<double, 9> p1 = {0, 0, 0, 0, 0, 0, 0, 1}, p2 = {0, 0, 0, 0, 0, 0, 0, 0, 1};
  if (c.lens == LensModel::brown && !model.direction(p1).isZero(0) && !model.direction(p2).isZero(0))
    add(What::turned, {{0, 0, 1}, {0, 0, 0, 1}, p1, p2}, {0.01 * w, 0.01 * w, 0.002, 0.002});
  else
    add(What::turned, {{0, 0, 1}, {0, 0, 0, 1}}, {0.01 * w, 0.01 * w});
  return all;
}

/// Along what photographs are sorted into groups: of turned ones the principal point, of which each tells more than of
/// the decentring.
Eigen::MatrixXd divided_by(const Hypothesis& hypothesis) {
  return hypothesis.what == What::turned ? Eigen::MatrixXd(hypothesis.directions.leftCols<2>()) : hypothesis.directions;
}

/// A change with what it explains.
struct Candidate {
  const Hypothesis* hypothesis = nullptr;
  Contrast contrast;
  StepFit fit;
  double value = 0;  // logarithm of its likelihood over no change, prior included
};

class Search {
 public:
  Search(const EffectModel& model, const BrownCamera& camera, const std::vector<RigidTransform>& poses)
      : model_(model),
        hypotheses_(hypotheses_of(model, camera)),
        in_order_(contrasts_in_order(model.size())),
        upside_down_(upside_down(poses)),
        none_(most_likely(model, {})) {}

  /// All changes at strengths that fit the best of them, which are put into `fitted_to`.
  std::vector<Candidate> candidates(Strengths& fitted_to) const {
    fitted_to = none_.strengths;
    std::vector<Candidate> found = scan(none_.strengths);
    if (found.empty()) return found;
    Optimum best = none_;
    best.log_likelihood = -std::numeric_limits<double>::infinity();
    for (int round = 0; round < 2; ++round) {
      std::map<std::pair<What, Split>, const Candidate*> leading;
      for (const Candidate& one : found) {
        const Candidate*& leader = leading[{one.hypothesis->what, one.contrast.split}];
        if (!leader || one.value > leader->value) leader = &one;
      }
      std::vector<const Candidate*> order;
      for (const auto& [key, leader] : leading) order.push_back(leader);
      std::stable_sort(order.begin(), order.end(), [](const auto* a, const auto* b) { return a->value > b->value; });
      // Without the change its size counts as scatter: the second round starts from strengths with one.
      const std::size_t most = round == 0 ? 10 : 5;
      for (std::size_t k = 0; k < std::min(most, order.size()); ++k) {
        const Step step = step_of(*order[k]);
        const Optimum fitted = most_likely(model_, round == 0 ? none_.strengths : best.strengths, &step);
        if (fitted.log_likelihood + order[k]->contrast.log_prior > best.log_likelihood)
          best = fitted, best.log_likelihood += order[k]->contrast.log_prior;
      }
      found = scan(best.strengths);
    }
    fitted_to = best.strengths;
    return found;
  }

  const Optimum& none() const { return none_; }

 private:
  static Step step_of(const Candidate& one) {
    return {one.contrast.weights, one.hypothesis->directions, one.hypothesis->sizes};
  }

  std::vector<Candidate> scan(const Strengths& strengths) const {
    const EffectFit fit(model_, strengths);
    const double offset =
        fit.log_likelihood() - none_.log_likelihood - std::log(static_cast<double>(hypotheses_.size()));
    std::vector<Candidate> found;
    for (const Hypothesis& hypothesis : hypotheses_) {
      std::vector<Contrast> contrasts = in_order_;
      if (hypothesis.what == What::undistorted || hypothesis.what == What::turned)
        std::erase_if(contrasts, [](const Contrast& c) { return c.split == Split::drift; });
      if (hypothesis.what == What::turned && upside_down_) contrasts.push_back(*upside_down_);
      if (hypothesis.what != What::aspect)
        for (Contrast& group : groups(fit, divided_by(hypothesis))) contrasts.push_back(std::move(group));
      for (Contrast& there_and_back : stretches(fit, hypothesis.directions, hypothesis.sizes))
        contrasts.push_back(std::move(there_and_back));
      for (Contrast& contrast : contrasts) {
        stop_point();
        Candidate one{&hypothesis, std::move(contrast), {}, 0};
        one.fit = fit.fit(step_of(one));
        one.value = one.fit.gain + one.contrast.log_prior + offset;
        if (std::isfinite(one.value)) found.push_back(std::move(one));
      }
    }
    return found;
  }

  const EffectModel& model_;
  std::vector<Hypothesis> hypotheses_;
  std::vector<Contrast> in_order_;
  std::optional<Contrast> upside_down_;
  Optimum none_;
};

/// Whether two splits are the same to who reads of them.
bool alike(const Contrast& a, const Contrast& b) {
  if (a.split != b.split && (a.split == Split::drift || b.split == Split::drift)) return false;
  const Eigen::ArrayXd x = a.weights.array() - a.weights.mean(), y = b.weights.array() - b.weights.mean();
  return std::abs((x * y).sum()) > 0.75 * std::sqrt(x.square().sum() * y.square().sum());
}

/// Part of the weights' variance that the places the photographs were taken from explain.
double by_place(const EffectModel& model, const Eigen::VectorXd& weights) {
  Eigen::MatrixXd columns(weights.size(), static_cast<Eigen::Index>(model.places().size()) + 1);
  columns.col(0).setOnes();
  for (std::size_t k = 0; k < model.places().size(); ++k)
    columns.col(static_cast<Eigen::Index>(k) + 1) = model.places()[k];
  const Eigen::VectorXd left = weights - columns * linear_algebra::least_squares_solution(columns, weights);
  return 1 - left.squaredNorm() / (weights.array() - weights.mean()).matrix().squaredNorm();
}

/// How far the principal point of the one part is from the mirror image of the other's, which it is where the one were
/// turned about the middle of the image; `camera` has the mean of both.
Eigen::Array2d off_the_mirror(const Candidate& one, const BrownCamera& camera) {
  const double turned = one.contrast.weights.mean();
  const Eigen::Vector2d mean(camera.cx, camera.cy), last(camera.width - 1, camera.height - 1);
  return (2 * mean + (1 - 2 * turned) * one.fit.by.head<2>() - last).array();
}

/// The mean of both is that of an adjustment to which they are one, which weighs them as it likes: that much of the
/// step.
constexpr double left_to_the_mean = 0.2;

/// What is asked of the photographs that are held upside down is said with it.
bool is_mirrored(const Candidate& one, const BrownCamera& camera) {
  if (one.contrast.split == Split::upside_down) return true;
  const Eigen::Array2d step = one.fit.by.head<2>().array().abs(), sigma = one.fit.sigma.head<2>().array();
  return (off_the_mirror(one, camera).abs() < 3 * sigma + left_to_the_mean * step).all();
}

/// What speaks for turned pictures against a principal point that moved by itself: that would be just the mirror image
/// by chance. Logarithm of the odds.
double by_the_mirror(const Candidate& one, const BrownCamera& camera) {
  if (one.contrast.split == Split::upside_down) return 0;
  const double usual = 0.02 * camera.width;  // of two principal points, each a hundredth off the middle
  const Eigen::Array2d off = off_the_mirror(one, camera).square(),
                       exact = one.fit.sigma.head<2>().array().square() +
                               (0.5 * left_to_the_mean * one.fit.by.head<2>().array()).square(),
                       open = exact + usual * usual;
  return 0.5 * (open / exact).log().sum() - 0.5 * (off / exact - off / open).sum();
}

/// With left and right exchanged: the same across, and no step along the columns.
bool is_flipped(double second, const CameraChange& change, const BrownCamera& camera) {
  const Eigen::Array2d by = change.by.head<2>().array(), sigma = change.sigma.head<2>().array();
  const double off = 2 * camera.cx + (1 - 2 * second) * by.x() - (camera.width - 1);
  return std::abs(by.x()) > 3 * sigma.x() && std::abs(off) < 3 * sigma.x() + left_to_the_mean * std::abs(by.x()) &&
         std::abs(by.y()) < 3 * sigma.y();
}

/// A program takes all of the distortion away: half of the photographs lack twice their mean.
bool is_plausible(const Candidate& one, const BrownCamera& camera) {
  if (one.hypothesis->what == What::turned) return is_mirrored(one, camera);
  if (one.hypothesis->what != What::undistorted) return true;
  return one.fit.by(0) > 0.7 - 3 * one.fit.sigma(0) && one.fit.by(0) < 4 + 3 * one.fit.sigma(0);
}

/// What of several parameters differs by more than three standard deviations, if that is but one.
What single_of_several(const StepFit& fit) {
  const auto is = [&](Eigen::Index k) { return std::abs(fit.by(k)) > 3 * fit.sigma(k); };
  const bool focus = is(0), point = is(1) || is(2), distortion = is(3) || is(4);
  if (focus + point + distortion != 1) return What::several;
  return focus ? What::focus : point ? What::principal_point : What::distortion;
}

What cause_of(const Candidate& one) {
  return one.hypothesis->what == What::several ? single_of_several(one.fit) : one.hypothesis->what;
}

/// The scatter from photograph to photograph that a change would be taken for, if it is one at all.
std::optional<Strengths::Kind> scatter_like(What what) {
  switch (what) {
    case What::focus:
    case What::several:
      return Strengths::focus;
    case What::principal_point:
    case What::turned:
      return Strengths::principal_point;
    default:
      return std::nullopt;
  }
}

std::optional<CameraChange> likeliest_change(const EffectModel& model, const Search& search,
                                             const BrownCamera& camera) {
  Strengths fitted_to;
  std::vector<Candidate> all = search.candidates(fitted_to);
  std::erase_if(all, [&](const Candidate& one) { return !is_plausible(one, camera); });
  if (all.empty()) return std::nullopt;
  const Candidate& best =
      *std::max_element(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.value < b.value; });
  double sum = 0, of_split = 0, mirrored = 0;
  std::map<What, double> of_cause;
  for (const Candidate& one : all) {
    const double odds = std::exp(one.value - best.value);
    sum += odds, of_cause[cause_of(one)] += odds;
    if (one.hypothesis->what == What::turned) mirrored += odds * std::exp(by_the_mirror(one, camera));
    if (alike(one.contrast, best.contrast)) of_split += odds;
  }
  if (const double moved = of_cause[What::principal_point], both = moved + of_cause[What::turned]; both > 0) {
    of_cause[What::turned] = both * mirrored / (mirrored + moved);
    of_cause[What::principal_point] = both - of_cause[What::turned];
  }
  // Against photographs that are alike; and against photographs that each differ, in no order.
  CameraChange change;
  const double beyond_scatter = best.value + std::log(sum);
  change.log_odds = beyond_scatter;
  if (const auto kind = scatter_like(best.hypothesis->what); kind && beyond_scatter > 0)
    change.log_odds +=
        search.none().log_likelihood - most_likely(model, search.none().strengths, nullptr, {*kind}).log_likelihood;
  change.or_place = by_place(model, best.contrast.weights) > mostly;
  if (!(change.log_odds > (change.or_place ? told_of_place_from : told_from))) return std::nullopt;
  // Parts whose photographs differ among themselves nearly as much as before are not the parts.
  constexpr double much = 0.02, nearly = 0.6;
  const double own = fitted_to.of(Strengths::focus);
  const bool still_scattered = own > much && own > nearly * search.none().strengths.of(Strengths::focus);
  const bool in_order = !still_scattered && beyond_scatter > -std::log(1 / clear_from - 1);
  change.split = best.contrast.split, change.second = best.contrast.second, change.period = best.contrast.period;
  change.by = best.fit.by, change.sigma = best.fit.sigma, change.what = best.hypothesis->what;
  for (const auto& [what, odds] : of_cause) change.causes.emplace_back(what, odds / sum);
  std::stable_sort(change.causes.begin(), change.causes.end(),
                   [](const auto& a, const auto& b) { return a.second > b.second; });
  change.split_is_clear = in_order && of_split > clear_from * sum;
  change.what_is_clear = change.causes.front().second > clear_from;
  // The step in that parameter alone, if there is one.
  const What clearest = change.causes.front().first;
  const Candidate* told = &best;
  if (change.what_is_clear && clearest != change.what) {
    const Candidate* named = nullptr;
    for (const Candidate& one : all)
      if (one.hypothesis->what == clearest && alike(one.contrast, best.contrast) &&
          (!named || one.value > named->value))
        named = &one;
    if (named)
      told = named, change.what = clearest, change.by = named->fit.by, change.sigma = named->fit.sigma;
    else
      change.what_is_clear = false;
  }
  if (change.what == What::principal_point)
    change.or_mirrored = is_flipped(best.contrast.weights.mean(), change, camera),
    change.or_turned = is_mirrored(*told, camera);
  return change;
}

/// Two settings in no order: of the principal distance, or of the principal point (turned pictures). Among all ways to
/// divide the photographs the right one is one of very many, so that likelihood hardly tells it from a setting that
/// scatters; that what the photographs say of it, each by itself, lies about two values does.
std::optional<CameraChange> two_settings(const EffectModel& model, Strengths strengths, const BrownCamera& camera,
                                         const Hypothesis& hypothesis) {
  constexpr double none = 1e-6;
  const auto scatter = scatter_like(hypothesis.what);
  if (!scatter) return std::nullopt;
  strengths.log(*scatter) = std::log(none);
  const EffectFit fit(model, strengths);
  const auto [values, sigmas] = along_their_axis(fit, divided_by(hypothesis));
  const auto groups = two_groups(values, sigmas);
  if (!groups) return std::nullopt;
  CameraChange change;
  change.split = Split::some, change.what = hypothesis.what, change.second = groups->second;
  change.log_odds = groups->log_odds, change.split_is_clear = change.what_is_clear = true;
  Candidate one{&hypothesis, {}, {}, 0};
  one.contrast.split = Split::some, one.contrast.weights = Eigen::VectorXd::Zero(values.size());
  for (const int k : groups->second) one.contrast.weights(k) = 1;
  if (hypothesis.what == What::focus) {
    change.by = Eigen::VectorXd::Constant(1, groups->by), change.sigma = Eigen::VectorXd::Constant(1, groups->sigma);
  } else {
    one.fit = fit.fit({one.contrast.weights, hypothesis.directions, hypothesis.sizes});
    change.by = one.fit.by, change.sigma = one.fit.sigma;
    if (!is_mirrored(one, camera)) change.what = What::principal_point;
  }
  change.causes = {{change.what, 1}};
  change.or_place = by_place(model, one.contrast.weights) > mostly;
  if (change.or_place && !(change.log_odds > told_of_place_from)) return std::nullopt;
  return change;
}

}  // namespace

std::optional<CameraChange> find_change(const CameraEvidence& evidence, const BrownCamera& camera,
                                        const std::vector<RigidTransform>& cam_from_object) {
  if (!can_be_compared(evidence, cam_from_object)) return std::nullopt;
  const EffectModel model(evidence, camera, cam_from_object);
  const Search search(model, camera, cam_from_object);
  if (auto change = likeliest_change(model, search, camera)) return change;
  for (const Hypothesis& hypothesis : hypotheses_of(model, camera))
    if (hypothesis.what == What::focus || hypothesis.what == What::turned)
      if (auto change = two_settings(model, search.none().strengths, camera, hypothesis)) return change;
  return std::nullopt;
}

bool divides(const CameraChange& change) { return change.split != Split::drift; }

std::vector<Scatter> causes_of_scatter(const CameraEvidence& evidence, const BrownCamera& camera,
                                       const std::vector<RigidTransform>& cam_from_object) {
  if (!can_be_compared(evidence, cam_from_object)) return {};
  const EffectModel model(evidence, camera, cam_from_object);
  const Optimum all = most_likely(model, {});
  const auto needed = [&](const std::vector<Strengths::Kind>& kinds) {
    return all.log_likelihood - most_likely(model, all.strengths, nullptr, kinds).log_likelihood > significant;
  };
  std::vector<Scatter> causes;
  for (const Strengths::Kind kind : {Strengths::focus, Strengths::principal_point, Strengths::rows})
    if (needed({kind})) causes.push_back({kind, all.strengths.of(kind)});
  // Rows and a principal point that move are much alike: where either would do, but not neither, both are named.
  const bool either =
      std::none_of(causes.begin(), causes.end(), [](const Scatter& s) { return s.kind != Strengths::focus; });
  if (either && needed({Strengths::principal_point, Strengths::rows}))
    causes.push_back({Strengths::rows, all.strengths.of(Strengths::rows), true});
  if (needed({Strengths::place})) causes.push_back({Strengths::place, all.strengths.of(Strengths::place)});
  return causes;
}

CameraTruth judge_camera(CameraEvidence evidence, const BrownCamera& camera,
                         const std::vector<RigidTransform>& cam_from_object) {
  CameraTruth truth;
  truth.evidence = std::move(evidence), truth.focal_length = camera.fx;
  truth.empirical = empirical_covariance(truth.evidence, cam_from_object);
  truth.change = find_change(truth.evidence, camera, cam_from_object);
  if (!truth.change) truth.scatter = causes_of_scatter(truth.evidence, camera, cam_from_object);
  if (!can_be_compared(truth.evidence, cam_from_object)) return truth;
  const EffectModel model(truth.evidence, camera, cam_from_object);
  const Strengths strengths = most_likely(model, {}).strengths;  // a change counts as scatter
  truth.own_effects = model.own_roots(strengths), truth.common_effects = model.common_roots(strengths);
  truth.corner_factor = std::max(1.0, strengths.of(Strengths::factor));
  return truth;
}

}  // namespace plumbline::markers

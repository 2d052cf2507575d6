#include "survey/model/circle_steps.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <tuple>

#include "geometry/median.hpp"
#include "survey/model/observation_equations.hpp"

namespace plumbline::survey {

namespace {

constexpr int kFewest = 3;                // pairs on either side
constexpr double kLeastTurn = 5 * kMgon;  // less is in the noise of short sights
constexpr double kLeastScatter = 0.5 * kMgon;
constexpr double kTimesScatter = 10;
constexpr size_t kMostSteps = 4;  // in one set-up; more is no turned circle

/// Two readings of one target in one set: the later minus the earlier, in face 1.
struct Pair {
  int earlier, later;
  double difference;
  double collimation;  ///< what a collimation of 1 adds
};

std::vector<Pair> pairs_of(const SurveyObservations& survey, int set_up, const std::vector<int>& directions,
                           const std::map<std::pair<int, int>, double>& sin_zenith) {
  std::map<std::tuple<std::string, int, double>, int> last;
  std::vector<Pair> pairs;
  for (const int i : directions) {
    const Observation& o = survey.observations[i];
    const double height = std::isnan(o.target_height) ? 0 : o.target_height;
    const auto [at, is_new] = last.try_emplace({o.to, o.set_number, height}, i);
    if (is_new) continue;
    const Observation& before = survey.observations[at->second];
    const auto turned = [](const Observation& r) { return r.value - (r.face == 2 ? std::numbers::pi : 0); };
    const auto face = [](const Observation& r) { return r.face == 1 ? 1.0 : r.face == 2 ? -1.0 : 0.0; };
    const auto steepness = sin_zenith.find({set_up, o.pointing});
    const double sine = steepness == sin_zenith.end() ? 1 : std::max(0.05, steepness->second);
    pairs.push_back({at->second, i, wrap_angle(turned(o) - turned(before)), (face(o) - face(before)) / sine});
    at->second = i;
  }
  return pairs;
}

struct Fit {
  CircleStep step;
  double misfit = 0;  ///< sum of absolute residuals
  double scatter = 0;
  size_t following = 0;
};

/// Turn before reading `first`, with the collimation that the pairs without it show.
std::optional<Fit> fit(const std::vector<Pair>& pairs, int set_up, int first) {
  std::vector<double> collimations, turns, residuals;
  const auto across = [&](const Pair& p) { return p.earlier < first && p.later >= first; };
  Fit f;
  for (const Pair& p : pairs) {
    ++(across(p) ? f.step.with : f.step.without);
    if (!across(p) && p.collimation != 0) collimations.push_back(p.difference / p.collimation);
  }
  if (f.step.with < kFewest || f.step.without < kFewest) return std::nullopt;
  const double collimation = collimations.empty() ? 0 : upper_median(collimations);
  const auto free = [&](const Pair& p) { return wrap_angle(p.difference - p.collimation * collimation); };
  for (const Pair& p : pairs)
    if (across(p)) turns.push_back(free(p));
  f.step.set_up = set_up, f.step.first = first, f.step.turn = upper_median(turns);
  for (const Pair& p : pairs) {
    residuals.push_back(std::abs(wrap_angle(free(p) - (across(p) ? f.step.turn : 0))));
    f.misfit += residuals.back();
  }
  f.scatter = std::max(kLeastScatter, 1.4826 * upper_median(residuals));
  f.following = static_cast<size_t>(
      std::count_if(residuals.begin(), residuals.end(), [&](double r) { return r < 5 * f.scatter; }));
  return f;
}

std::optional<CircleStep> largest_step(const std::vector<Pair>& pairs, int set_up, const std::vector<int>& directions) {
  std::optional<Fit> best;
  for (const int first : directions)
    if (const auto f = fit(pairs, set_up, first); f && (!best || f->misfit < best->misfit)) best = f;
  if (!best || best->following * 10 < pairs.size() * 9) return std::nullopt;
  if (std::abs(best->step.turn) < std::max(kLeastTurn, kTimesScatter * best->scatter)) return std::nullopt;
  return best->step;
}

}  // namespace

std::vector<CircleStep> circle_steps(const SurveyObservations& survey) {
  std::map<int, std::vector<int>> directions;
  std::map<std::pair<int, int>, double> sin_zenith;  // by set-up and pointing
  for (size_t i = 0; i < survey.observations.size(); ++i) {
    const Observation& o = survey.observations[i];
    if (o.set_up < 0 || !std::isnan(o.sigma)) continue;
    if (o.kind == ObservationKind::direction) directions[o.set_up].push_back(static_cast<int>(i));
    if (o.kind == ObservationKind::zenith_angle && o.pointing >= 0)
      sin_zenith[{o.set_up, o.pointing}] = std::abs(std::sin(o.value));
  }
  std::vector<CircleStep> steps;
  for (const auto& [set_up, readings] : directions) {
    std::vector<Pair> pairs = pairs_of(survey, set_up, readings, sin_zenith);
    for (size_t k = 0; k < kMostSteps; ++k) {
      const auto step = largest_step(pairs, set_up, readings);
      if (!step) break;
      steps.push_back(*step);
      for (Pair& p : pairs)
        if (p.earlier < step->first && p.later >= step->first) p.difference = wrap_angle(p.difference - step->turn);
    }
  }
  return steps;
}

std::string in_words(const CircleStep& step, const SurveyObservations& survey) {
  const Observation& o = survey.observations[step.first];
  const std::string turn = fmt::format("{:.1f} mgon", step.turn / kMgon);
  return "the circle of set-up " + survey.set_ups[step.set_up].id + " was turned by " + turn + " before " + o.to +
         " was sighted" + (o.face == 2 ? " in face 2" : "") + " (" + place(o.source) +
         "): " + std::to_string(step.with) + " pairs of readings to one target show it, " +
         std::to_string(step.without) +
         " do not have it between them. The directions from there on are turned back; look whether the tripod stood "
         "firm";
}

}  // namespace plumbline::survey

// What would mend a failing rule of a plan. Every remedy is tried out on a copy of the layout before it is proposed:
// first single sights that are possible but not planned, then more sets, then one more set-up.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <set>
#include <sstream>

#include "base/text/words.hpp"
#include "plumbline/stop.hpp"
#include "survey/plan/plan_effect.hpp"
#include "survey/plan/plan_layout.hpp"

namespace plumbline::survey {

namespace {

using Eigen::Index;
using Eigen::Vector3d;

std::string describe(const PlanLayout& layout, const std::vector<Sight>& sights) {
  std::string text = "sight ";
  for (size_t s = 0; s < layout.set_ups().size(); ++s) {
    std::vector<std::string> markers;
    for (const Sight& sight : sights)
      if (sight.first == s) markers.push_back(layout.markers()[sight.second].id);
    if (markers.empty()) continue;
    if (text != "sight ") text += "; ";
    text += text::join(markers, 10) + " also from " + layout.set_ups()[s].id;
  }
  return text;
}

PlanRemedy remedy_of(const PlanLayout& layout, const std::vector<Sight>& sights) {
  PlanRemedy remedy;
  remedy.text = describe(layout, sights);
  remedy.sightings = static_cast<int>(sights.size());
  for (const Sight& s : sights) remedy.added.push_back(layout.sight(s.first, s.second));
  return remedy;
}

/// Shorter and less oblique is better.
double quality(const PlannedSight& s) {
  return s.length / std::max(0.1, std::isnan(s.incidence) ? 1.0 : std::cos(s.incidence));
}

// ---------------------------------------------------------------------------------------------------- new set-ups

/// Where an instrument could stand before the facade: on the heights from which the plan sights the markers concerned,
/// in usual depths, along the whole facade and a bit beyond.
std::vector<PlannedSetUp> places_for_a_set_up(const PlanLayout& layout, const std::function<bool(size_t)>& keep) {
  Vector3d centre = Vector3d::Zero(), normal = Vector3d::Zero(), stations = Vector3d::Zero();
  for (const auto& m : layout.markers()) {
    centre += m.position / static_cast<double>(layout.markers().size());
    if (m.normal.allFinite()) normal += m.normal.normalized();
  }
  std::set<double> heights;
  for (size_t s = 0; s < layout.set_ups().size(); ++s) {
    stations += layout.set_ups()[s].position / static_cast<double>(layout.set_ups().size());
    bool concerned = false;
    for (size_t m = 0; m < layout.markers().size(); ++m) concerned = concerned || (layout.planned(s, m) && keep(m));
    if (concerned) heights.insert(std::round(10 * layout.set_ups()[s].position.z()) / 10);
  }
  if (heights.empty())
    for (const auto& s : layout.set_ups()) heights.insert(std::round(10 * s.position.z()) / 10);
  if (normal.head<2>().norm() < 1e-6) normal = stations - centre;
  normal.z() = 0;
  if (normal.norm() < 1e-6) return {};
  normal.normalize();
  const Vector3d along = Vector3d::UnitZ().cross(normal);
  double low = 0, high = 0;
  for (const auto& m : layout.markers()) {
    low = std::min(low, along.dot(m.position - centre));
    high = std::max(high, along.dot(m.position - centre));
  }
  std::vector<PlannedSetUp> places;
  const double step = std::max(2.0, (high - low + 8) / 8);
  for (double height : heights)
    for (double depth : {6.0, 8.0, 10.0, 12.0, 15.0, 20.0, 25.0})
      for (double offset = low - 4; offset <= high + 4; offset += step) {
        Vector3d place = centre + depth * normal + offset * along;
        place.z() = height;
        const bool crowded = std::any_of(layout.set_ups().begin(), layout.set_ups().end(),
                                         [&](const auto& s) { return (s.position - place).norm() < 1.5; });
        if (!crowded) places.push_back({"new", (10 * place).array().round() / 10});
      }
  return places;
}

struct NewSetUp {
  PlannedSetUp place;
  PlanRemedy remedy;
};

/// The place with the greatest merit above 0 of the layout that has it; `keep` tells which of its sights matter.
std::optional<NewSetUp> best_new_set_up(const PlanLayout& layout, const std::function<bool(size_t)>& keep,
                                        const std::function<double(const PlanLayout&)>& merit) {
  double best = 0;
  PlannedSetUp chosen;
  std::vector<size_t> sights;
  for (PlannedSetUp place : places_for_a_set_up(layout, keep)) {
    stop_point();
    PlanLayout trial = layout;
    trial.add_set_up(place);
    const size_t s = trial.set_ups().size() - 1;
    std::vector<size_t> seen;
    for (size_t m = 0; m < trial.markers().size(); ++m)
      if (trial.possible(s, m) && keep(m)) {
        seen.push_back(m);
        place.sees.push_back(trial.markers()[m].id);
      }
    if (seen.empty()) continue;
    trial = layout;
    trial.add_set_up(place);
    const double worth = merit(trial);
    if (worth <= best) continue;
    best = worth;
    chosen = place;
    sights = seen;
  }
  if (best <= 0) return std::nullopt;
  PlanLayout with = layout;
  with.add_set_up(chosen);
  PlanRemedy remedy;
  std::ostringstream text;
  text.precision(1);
  text << std::fixed << "add a set-up near E " << chosen.position.x() << ", N " << chosen.position.y() << ", H "
       << chosen.position.z() << " m and sight " << text::join(chosen.sees, 10);
  remedy.text = text.str();
  remedy.sightings = kSetUpCost + static_cast<int>(sights.size());
  for (size_t m : sights) remedy.added.push_back(with.sight(with.set_ups().size() - 1, m));
  return NewSetUp{chosen, remedy};
}

std::vector<PlanRemedy> as_list(const std::optional<NewSetUp>& found) {
  return found ? std::vector<PlanRemedy>{found->remedy} : std::vector<PlanRemedy>{};
}

/// 1 + a bit for good sights, if the condition holds; 0 otherwise.
double merit_if(bool holds, const PlanLayout& trial) {
  if (!holds) return 0;
  double worst = 0;
  const size_t s = trial.set_ups().size() - 1;
  for (size_t m = 0; m < trial.markers().size(); ++m)
    if (trial.planned(s, m)) worst = std::max(worst, quality(trial.sight(s, m)));
  return 1 + 1 / (1 + worst);
}

/// Pairs of set-ups, those first that lack fewest common markers.
std::vector<std::pair<size_t, size_t>> pairs_by_common_markers(const PlanLayout& layout) {
  std::vector<std::pair<int, std::pair<size_t, size_t>>> pairs;
  for (size_t a = 0; a < layout.set_ups().size(); ++a)
    for (size_t b = 0; b < layout.set_ups().size(); ++b) {
      int common = 0;
      for (size_t m = 0; m < layout.markers().size(); ++m) common += layout.planned(a, m) && layout.planned(b, m);
      if (a != b) pairs.push_back({-common, {a, b}});
    }
  std::sort(pairs.begin(), pairs.end());
  std::vector<std::pair<size_t, size_t>> sorted;
  for (const auto& pair : pairs) sorted.push_back(pair.second);
  return sorted;
}

}  // namespace

std::vector<PlanRemedy> remedies_for_set_ups(const PlanLayout& layout, const PlanOptions& options) {
  const auto wants = [&](const PlanLayout& plan, size_t m) {
    return plan.set_ups_seeing(m) < options.set_ups_per_marker;
  };
  std::vector<Sight> sights;
  PlanLayout mended = layout;
  size_t open = 0;
  for (size_t m = 0; m < layout.markers().size(); ++m) {
    stop_point();
    std::vector<Sight> spare = spare_sights(layout, [&](size_t other) { return other == m; });
    std::sort(spare.begin(), spare.end(), [&](const Sight& a, const Sight& b) {
      return quality(layout.sight(a.first, m)) < quality(layout.sight(b.first, m));
    });
    for (size_t i = 0; i < spare.size() && wants(mended, m); ++i) {
      mended.add_sight(spare[i].first, m);
      sights.push_back(spare[i]);
    }
    open += wants(mended, m);
  }
  PlanRemedy all;
  if (!sights.empty()) all = remedy_of(layout, sights);
  // What no sight of the planned set-ups mends needs further ones, each where it sees most of what is left.
  for (int added = 1; open > 0 && added <= 4; ++added) {
    const PlanLayout before = mended;
    const auto next = best_new_set_up(
        before, [&](size_t m) { return wants(before, m); },
        [&](const PlanLayout& trial) {
          double seen = 0;
          for (size_t m = 0; m < trial.markers().size(); ++m) seen += trial.planned(trial.set_ups().size() - 1, m);
          return seen > 0 ? seen + merit_if(true, trial) : 0;
        });
    if (!next) break;
    mended.add_set_up(next->place);
    all.text += (all.text.empty() ? "" : "; and ") + next->remedy.text;
    all.sightings += next->remedy.sightings;
    all.added.insert(all.added.end(), next->remedy.added.begin(), next->remedy.added.end());
    open = 0;
    for (size_t m = 0; m < layout.markers().size(); ++m) open += wants(mended, m);
  }
  if (all.text.empty()) return {};
  if (open > 0) all.text += "; " + std::to_string(open) + " markers stay with too few set-ups even then";
  return {all};
}

std::vector<PlanRemedy> remedies_for_sharing(const PlanLayout& layout, const PlanOptions& options, int lower,
                                             int upper) {
  const auto of_the_pair = [&](size_t m) {
    return layout.markers()[m].floor == lower || layout.markers()[m].floor == upper;
  };
  std::vector<Sight> fewest;
  for (size_t s = 0; s < layout.set_ups().size(); ++s) {
    PlanLayout trial = layout;
    std::vector<Sight> added;
    for (int floor : {lower, upper}) {
      auto spare = spare_sights(layout, [&](size_t m) { return layout.markers()[m].floor == floor; });
      std::erase_if(spare, [&](const Sight& sight) { return sight.first != s; });
      std::sort(spare.begin(), spare.end(), [&](const Sight& a, const Sight& b) {
        return quality(layout.sight(s, a.second)) < quality(layout.sight(s, b.second));
      });
      int here = 0;
      for (size_t m : layout.on_floor(floor)) here += layout.planned(s, m);
      for (size_t i = 0; i < spare.size() && here < options.shared_markers; ++i, ++here) {
        trial.add_sight(s, spare[i].second);
        added.push_back(spare[i]);
      }
    }
    if (added.empty() || trial.shared_markers(lower, upper) < options.shared_markers) continue;
    if (fewest.empty() || added.size() < fewest.size()) fewest = added;
  }
  if (!fewest.empty()) return {remedy_of(layout, fewest)};
  return as_list(best_new_set_up(layout, of_the_pair, [&](const PlanLayout& trial) {
    return merit_if(trial.shared_markers(lower, upper) >= options.shared_markers, trial);
  }));
}

std::vector<PlanRemedy> remedies_for_rank(const PlanLayout& layout, const PlanOptions& options) {
  // Two set-ups hang together through two common markers that do not stand above each other; where they do not, the
  // missing ones are sighted from the first.
  PlanLayout trial = layout;
  std::vector<Sight> added;
  const auto apart = [&](size_t a, size_t b) {
    return (layout.markers()[a].position - layout.markers()[b].position).head<2>().norm();
  };
  for (const auto& [a, b] : pairs_by_common_markers(layout)) {
    stop_point();
    if (predict(trial, options.sets).adjustable) break;
    std::vector<size_t> common, spare;
    for (size_t m = 0; m < layout.markers().size(); ++m) {
      if (trial.planned(a, m) && trial.planned(b, m)) common.push_back(m);
      if (trial.planned(b, m) && !trial.planned(a, m) && trial.possible(a, m)) spare.push_back(m);
    }
    const auto width = [&](size_t m) {
      double widest = 0;
      for (size_t other : common) widest = std::max(widest, apart(m, other));
      return widest;
    };
    while (std::none_of(common.begin(), common.end(), [&](size_t m) { return width(m) > 1.0; }) && !spare.empty()) {
      const auto next =
          std::max_element(spare.begin(), spare.end(), [&](size_t x, size_t y) { return width(x) < width(y); });
      trial.add_sight(a, *next);
      added.emplace_back(a, *next);
      common.push_back(*next);
      spare.erase(next);
    }
  }
  if (!added.empty() && predict(trial, options.sets).adjustable) return {remedy_of(layout, added)};
  // Trying a place costs an adjustment; one that sees more is tried only after one that sees less has failed.
  size_t most = 0;
  return as_list(best_new_set_up(
      layout, [](size_t) { return true; },
      [&](const PlanLayout& with) {
        size_t seen = 0;
        for (size_t m = 0; m < with.markers().size(); ++m) seen += with.planned(with.set_ups().size() - 1, m);
        if (seen <= most || !predict(with, options.sets).adjustable) return 0.0;
        most = seen;
        return static_cast<double>(seen);
      }));
}

std::vector<PlanRemedy> remedies_for_transfer(const PlanLayout& layout, const PlanOptions& options, int lower,
                                              int upper, PlanPredictions& predictions) {
  constexpr size_t kMostSights = 24;
  const double wanted = options.tolerance / 5;
  std::vector<PlanRemedy> remedies;
  const auto predicted = [&](const PlanLayout& trial) {
    return transfer_sigma(trial, predict(trial, options.sets), lower, upper);
  };
  const PlanPrediction& prediction = predictions.of(options.sets);
  const std::vector<Sight> sights = sights_for_transfer(layout, prediction, options, lower, upper, wanted, kMostSights);
  if (!sights.empty()) {
    PlanLayout trial = layout;
    for (const Sight& s : sights) trial.add_sight(s.first, s.second);
    remedies.push_back(remedy_of(layout, sights));
    remedies.back().text += ": " + text::millimetres(predicted(trial), 2);
  }
  for (int sets = options.sets + 1; sets <= 8; ++sets) {
    const double sigma = transfer_sigma(layout, predictions.of(sets), lower, upper);
    if (sigma > wanted) continue;
    remedies.push_back({"",
                        "measure " + std::to_string(sets) + " sets everywhere: " + text::millimetres(sigma, 2),
                        (sets - options.sets) * layout.sightings(),
                        {}});
    break;
  }
  const HeightWeights weights = transfer_weights(layout.seen_on_floor(lower), layout.seen_on_floor(upper));
  const auto set_up = best_new_set_up(
      layout, [&](size_t m) { return layout.markers()[m].floor == lower || layout.markers()[m].floor == upper; },
      [&](const PlanLayout& trial) {
        const double sigma = height_sigma_with(layout, prediction, options, trial, weights);
        return sigma <= wanted ? wanted / sigma : 0;
      });
  if (set_up) {
    PlanLayout trial = layout;
    trial.add_set_up(set_up->place);
    const double sigma = predicted(trial);
    remedies.push_back(set_up->remedy);
    remedies.back().text += ": " + text::millimetres(sigma, 2);
    if (sigma > wanted) remedies.pop_back();
  }
  if (remedies.empty())
    remedies.push_back({"",
                        "neither the sights left, eight sets nor one more set-up suffice: use a better instrument, or "
                        "transfer the height with level and tape",
                        0,
                        {}});
  return remedies;
}

}  // namespace plumbline::survey

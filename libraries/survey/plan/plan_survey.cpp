#include "survey/plan/plan_survey.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "base/text/text.hpp"
#include "base/text/words.hpp"
#include "survey/plan/plan_layout.hpp"

namespace plumbline::survey {

namespace {

/// Rules, prediction and remedies of one layout, collected in the order they are read in.
class Planner {
 public:
  Planner(const PlanLayout& layout, const PlanOptions& options)
      : layout_(layout), options_(options), predictions_(layout) {
    result_.floors = layout.floors();
  }

  PlanResult run() {
    for (size_t s = 0; s < layout_.set_ups().size(); ++s)
      for (size_t m = 0; m < layout_.markers().size(); ++m)
        if (layout_.planned(s, m)) result_.sights.push_back(layout_.sight(s, m));
    check_spacing();
    check_markers_per_floor();
    check_column();
    check_set_ups_per_marker();
    check_shared_markers();
    check_limits();
    check_precision();
    std::stable_sort(result_.remedies.begin(), result_.remedies.end(),
                     [](const PlanRemedy& a, const PlanRemedy& b) { return a.sightings < b.sightings; });
    return std::move(result_);
  }

 private:
  void add_rule(const std::string& name, bool holds, const std::string& text, std::vector<std::string> points = {}) {
    result_.rules.push_back({name, holds, text, std::move(points)});
  }

  void add_remedies(const std::string& rule, std::vector<PlanRemedy> found) {
    for (PlanRemedy& remedy : found) {
      remedy.rule = rule;
      result_.remedies.push_back(std::move(remedy));
    }
  }

  void check_spacing() {
    std::vector<std::string> off;
    const auto& markers = layout_.markers();
    for (const PlannedMarker& m : markers) {
      double nearest = std::numeric_limits<double>::infinity();
      for (const PlannedMarker& other : markers)
        if (&other != &m) nearest = std::min(nearest, (other.position - m.position).norm());
      if (std::abs(nearest - options_.spacing) > options_.spacing_tolerance) off.push_back(m.id);
    }
    const std::string wanted =
        text::format_fixed(options_.spacing, 1) + " m (± " + text::format_fixed(options_.spacing_tolerance, 1) + " m)";
    add_rule("marker spacing", off.empty(),
             off.empty() ? "from every marker to the nearest it is " + wanted
                         : "the nearest marker is not " + wanted + " from " + text::join(off, 10),
             off);
    if (!off.empty())
      result_.remedies.push_back({"marker spacing", "move or add markers beside " + text::join(off, 10), 0, {}});
  }

  void check_markers_per_floor() {
    std::string text;
    bool holds = true;
    for (int floor : result_.floors) {
      const auto n = static_cast<int>(layout_.on_floor(floor).size());
      text += (text.empty() ? "" : ", ") + std::string("floor ") + std::to_string(floor) + ": " + std::to_string(n);
      if (n >= options_.markers_per_floor) continue;
      holds = false;
      result_.remedies.push_back(
          {"markers per floor",
           "mount " + std::to_string(options_.markers_per_floor - n) + " more on floor " + std::to_string(floor),
           0,
           {}});
    }
    add_rule("markers per floor", holds, text + "; wanted " + std::to_string(options_.markers_per_floor));
  }

  void check_column() {
    std::map<int, std::set<int>> floors_of;
    for (const auto& m : layout_.markers())
      if (m.column > 0) floors_of[m.column].insert(m.floor);
    std::string complete, nearly;
    size_t fewest = result_.floors.size();
    for (const auto& [column, floors] : floors_of) {
      const size_t missing = result_.floors.size() - floors.size();
      if (missing == 0) complete += (complete.empty() ? "" : ", ") + std::to_string(column);
      if (missing == 0 || missing >= fewest) continue;
      fewest = missing;
      nearly = "mount a marker in column " + std::to_string(column) + " on floor";
      for (int floor : result_.floors)
        if (!floors.contains(floor)) nearly += " " + std::to_string(floor);
    }
    add_rule(
        "vertical marker column", !complete.empty(),
        complete.empty() ? "no column has a marker on every floor" : "a marker on every floor in column " + complete);
    if (complete.empty())
      result_.remedies.push_back(
          {"vertical marker column",
           nearly.empty() ? "mount one marker above the other on every floor, and number the column" : nearly,
           0,
           {}});
  }

  void check_set_ups_per_marker() {
    std::vector<std::string> ids;
    for (size_t m = 0; m < layout_.markers().size(); ++m)
      if (layout_.set_ups_seeing(m) < options_.set_ups_per_marker) ids.push_back(layout_.markers()[m].id);
    const std::string wanted = std::to_string(options_.set_ups_per_marker) + " set-ups";
    add_rule("set-ups per marker", ids.empty(),
             ids.empty() ? "every marker is seen from at least " + wanted
                         : "seen from fewer than " + wanted + ": " + text::join(ids, 10),
             ids);
    if (!ids.empty()) add_remedies("set-ups per marker", remedies_for_set_ups(layout_, options_));
  }

  void check_shared_markers() {
    for (size_t k = 0; k + 1 < result_.floors.size(); ++k) {
      const int lower = result_.floors[k], upper = result_.floors[k + 1];
      const int shared = layout_.shared_markers(lower, upper);
      const std::string name = "shared markers, floors " + std::to_string(lower) + " and " + std::to_string(upper);
      const bool holds = shared >= options_.shared_markers;
      add_rule(name, holds,
               "set-ups that see both floors join " + std::to_string(shared) + " markers of each, wanted " +
                   std::to_string(options_.shared_markers));
      if (!holds) add_remedies(name, remedies_for_sharing(layout_, options_, lower, upper));
    }
  }

  void check_limits() {
    constexpr double kDegree = std::numbers::pi / 180;
    std::string text;
    std::vector<std::string> points;
    for (const PlannedSight& s : layout_.refused()) {
      if (points.size() < 6)
        text +=
            (text.empty() ? "" : "; ") + s.set_up + " to " + s.marker + " (" + text::format_fixed(s.length, 1) + " m" +
            (std::isnan(s.incidence) ? ")" : ", incidence " + text::format_fixed(s.incidence / kDegree, 0) + " deg)");
      points.push_back(s.marker);
    }
    if (points.size() > 6) text += " and " + std::to_string(points.size() - 6) + " more";
    const std::string limits = text::format_fixed(options_.largest_range, 0) + " m, incidence " +
                               text::format_fixed(options_.largest_incidence / kDegree, 0) + " deg, elevation " +
                               text::format_fixed(options_.steepest_sight / kDegree, 0) + " deg";
    add_rule("range and incidence", points.empty(),
             points.empty() ? "every sight is within " + limits
                            : "planned but not within " + limits + ", so not counted: " + text,
             points);
    if (!points.empty())
      result_.remedies.push_back(
          {"range and incidence", "leave these sights out, or move the set-up in front of the markers", 0, {}});
  }

  void check_precision() {
    const PlanPrediction& prediction = predictions_.of(options_.sets);
    result_.adjustable = prediction.adjustable;
    add_rule("determined", prediction.adjustable,
             prediction.adjustable
                 ? "the network is determined with redundancy " + std::to_string(prediction.network.degrees_of_freedom)
                 : prediction.problem);
    if (!prediction.adjustable) {
      add_remedies("determined", remedies_for_rank(layout_, options_));
      return;
    }
    add_drifts(prediction);
    for (size_t k = 0; k + 1 < result_.floors.size(); ++k)
      add_transfer(prediction, result_.floors[k], result_.floors[k + 1]);
    result_.predicted = prediction.network;
  }

  void add_drifts(const PlanPrediction& prediction) {
    HeightWeights drift;
    for (int floor : result_.floors) {
      const auto here = layout_.seen_on_floor(floor);
      for (size_t m : here) drift.emplace_back(m, 1.0 / static_cast<double>(here.size()));
      result_.drifts.push_back({floor, prediction.height_sigma(layout_, drift)});
    }
  }

  void add_transfer(const PlanPrediction& prediction, int lower, int upper) {
    const double sigma = transfer_sigma(layout_, prediction, lower, upper);
    if (!std::isfinite(sigma)) return;  // a floor that nobody sees: another rule says so
    result_.transfers.push_back({lower, upper, 0, sigma});
    for (int column : layout_.columns()) {
      const auto in_column = [&](int floor) {
        auto which = layout_.seen_on_floor(floor);
        std::erase_if(which, [&](size_t m) { return layout_.markers()[m].column != column; });
        return which;
      };
      const auto below = in_column(lower), above = in_column(upper);
      if (below.empty() || above.empty()) continue;
      result_.transfers.push_back(
          {lower, upper, column, prediction.height_sigma(layout_, transfer_weights(below, above))});
    }
    const double wanted = options_.tolerance / 5;  // control should be five times better than what it judges
    const std::string name = "height transfer, floor " + std::to_string(lower) + " to " + std::to_string(upper);
    add_rule(name, sigma <= wanted,
             "predicted sigma " + text::millimetres(sigma, 2) + ", wanted " + text::millimetres(wanted, 2) +
                 " (a fifth of the tolerance)");
    if (sigma > wanted) add_remedies(name, remedies_for_transfer(layout_, options_, lower, upper, predictions_));
  }

  const PlanLayout& layout_;
  const PlanOptions& options_;
  PlanPredictions predictions_;
  PlanResult result_;
};

}  // namespace

PlanResult plan_survey(const std::vector<PlannedMarker>& markers, const std::vector<PlannedSetUp>& set_ups,
                       const PlanOptions& options) {
  const PlanLayout layout(markers, set_ups, options);
  return Planner(layout, options).run();
}

}  // namespace plumbline::survey

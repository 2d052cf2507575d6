#include "plan_node.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "ellipsoid_artifact.hpp"
#include "survey/plan/plan_survey.hpp"

namespace plumbline::survey {

namespace {

std::vector<PlannedMarker> planned_markers(const PointsT& points, const PlatesT* plates) {
  std::vector<PlannedMarker> markers;
  for (const auto& p : points.points) {
    PlannedMarker m{p->id, p->position, Eigen::Vector3d::Constant(kNotGiven)};
    for (size_t i = 0; plates && i < plates->plates.size(); ++i) {
      const PlateT& plate = *plates->plates[i];
      if (plate.anchor != p->id) continue;
      m.floor = plate.floor;
      m.column = plate.column;
      m.normal = plate.nominal_rotation * Eigen::Vector3d::UnitZ();
    }
    markers.push_back(std::move(m));
  }
  return markers;
}

std::vector<PlannedSetUp> planned_set_ups(const plumbline::SurveyObservationsT& given) {
  std::vector<PlannedSetUp> set_ups;
  for (const auto& p : given.points) set_ups.push_back({p->id, p->position, {}});
  for (const auto& o : given.observations)
    for (PlannedSetUp& s : set_ups)
      if (s.id == o->from) s.sees.push_back(o->to);
  return set_ups;
}

std::unique_ptr<PlannedSightT> pack(const PlannedSight& sight) {
  auto item = std::make_unique<PlannedSightT>();
  item->set_up = sight.set_up;
  item->marker = sight.marker;
  item->length = sight.length;
  item->incidence = sight.incidence;
  return item;
}

void pack_rules(const PlanResult& r, SurveyPlanT& plan) {
  plan.holds = true;
  for (const PlannedRule& rule : r.rules) {
    auto item = std::make_unique<PlanRuleT>();
    item->name = rule.name;
    item->holds = rule.holds;
    item->text = rule.text;
    item->points = rule.points;
    plan.holds = plan.holds && rule.holds;
    plan.rules.push_back(std::move(item));
  }
  for (const PlanRemedy& remedy : r.remedies) {
    auto item = std::make_unique<PlanRemedyT>();
    item->rule = remedy.rule;
    item->text = remedy.text;
    item->sightings = remedy.sightings;
    for (const PlannedSight& sight : remedy.added) item->sights.push_back(pack(sight));
    plan.remedies.push_back(std::move(item));
  }
}

/// Markers and set-ups; what the prediction does not cover has no precision.
void pack_points(const PlanResult& r, const std::vector<PlannedMarker>& markers,
                 const std::vector<PlannedSetUp>& set_ups, SurveyPlanT& plan) {
  const auto add = [&](const std::string& id, const Eigen::Vector3d& position) {
    const auto at = std::find_if(r.predicted.points.begin(), r.predicted.points.end(),
                                 [&](const ResultPoint& p) { return p.id == id; });
    const bool known = at != r.predicted.points.end();
    auto item = std::make_unique<PointT>();
    item->id = id;
    item->position = position;
    item->sigma = known ? r.predicted.sigma(*at) : Eigen::Vector3d(Eigen::Vector3d::Constant(kNotGiven));
    plan.points.push_back(std::move(item));
    if (known) plan.ellipsoids.push_back(ellipsoid_artifact(id, r.predicted.covariance(*at, *at)));
  };
  for (const PlannedMarker& m : markers) add(m.id, m.position);
  for (const PlannedSetUp& s : set_ups) add(s.id, s.position);
}

void pack_prediction(const PlanResult& r, SurveyPlanT& plan) {
  plan.datum_points = r.predicted.datum_points;
  for (const PlannedTransfer& t : r.transfers) {
    auto item = std::make_unique<PlannedTransferT>();
    item->from_floor = t.from_floor;
    item->to_floor = t.to_floor;
    item->column = t.column;
    item->sigma = t.sigma;
    plan.transfers.push_back(std::move(item));
  }
  for (const PlannedDrift& d : r.drifts) {
    auto item = std::make_unique<PlannedDriftT>();
    item->floor = d.floor;
    item->sigma = d.sigma;
    plan.drifts.push_back(std::move(item));
  }
}

SurveyPlanT to_artifact(const PlanResult& r, const PlanOptions& options) {
  SurveyPlanT plan;
  plan.profile = options.profile.name;
  plan.sets = options.sets;
  pack_rules(r, plan);
  for (const PlannedSight& sight : r.sights) plan.sights.push_back(pack(sight));
  pack_prediction(r, plan);
  return plan;
}

/// What became of the rules, the one of rank before all others: without it nothing is predicted.
std::string plan_verdict(const std::vector<PlannedRule>& rules) {
  std::string broken;
  size_t count = 0;
  for (const PlannedRule& rule : rules) {
    if (rule.holds) continue;
    if (rule.name == "determined") return "NOT DETERMINED: " + rule.text;
    if (count++ < 3) broken += (broken.empty() ? "" : "; ") + rule.name;
  }
  if (count == 0) return "determined, all " + std::to_string(rules.size()) + " rules hold";
  return "determined, " + std::to_string(count) + " of " + std::to_string(rules.size()) +
         " rules do not hold: " + broken + (count > 3 ? "; …" : "");
}

}  // namespace

void PlanNode::run(Context& context) {
  constexpr double kDegree = std::numbers::pi / 180;
  PlanOptions options;
  const auto planned_survey = set_ups.unpack();
  std::string remark;
  options.profile = chosen_profile(planned_survey.info ? planned_survey.info->instrument : "", remark);
  if (!remark.empty()) context.info(remark);
  options.sets = static_cast<int>(*sets);
  options.set_ups_per_marker = static_cast<int>(*set_ups_per_marker);
  options.shared_markers = static_cast<int>(*shared_markers);
  options.markers_per_floor = static_cast<int>(*markers_per_floor);
  options.spacing = *spacing;
  options.spacing_tolerance = *spacing_tolerance;
  options.largest_range = *largest_range;
  options.largest_incidence = *largest_incidence * kDegree;
  options.steepest_sight = *steepest_sight * kDegree;
  options.tolerance = *tolerance;
  PlatesT layout;
  if (plates) layout = plates.unpack();
  const auto planned = planned_markers(markers.unpack(), plates ? &layout : nullptr);
  const auto places = planned_set_ups(planned_survey);
  const PlanResult result = plan_survey(planned, places, options);
  const std::string verdict = plan_verdict(result.rules);
  context.info(verdict);
  context.metric("invalid", result.adjustable ? 0 : 1, "1");
  for (const PlannedRule& rule : result.rules)
    if (!rule.holds) context.warn(rule.name + ": " + rule.text);
  for (const PlanRemedy& remedy : result.remedies) context.info("for " + remedy.rule + ": " + remedy.text);
  SurveyPlanT out = to_artifact(result, options);
  pack_points(result, planned, places, out);
  plan.commit(out);
}

}  // namespace plumbline::survey

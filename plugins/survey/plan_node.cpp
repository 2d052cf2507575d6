#include "plan_node.hpp"

#include <cmath>
#include <numbers>

#include "plan_survey.hpp"

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

SurveyPlanT to_artifact(const PlanResult& r) {
  SurveyPlanT plan;
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
  plan.remedies = r.remedies;
  for (const PlannedSight& sight : r.sights) {
    auto item = std::make_unique<PlannedSightT>();
    item->set_up = sight.set_up;
    item->marker = sight.marker;
    item->length = sight.length;
    item->incidence = sight.incidence;
    plan.sights.push_back(std::move(item));
  }
  for (const ResultPoint& p : r.predicted.points) {
    auto item = std::make_unique<PointT>();
    item->id = p.id;
    item->position = p.position;
    item->sigma = r.predicted.sigma(p);
    plan.points.push_back(std::move(item));
  }
  for (size_t k = 0; k < r.transfer_sigma.size(); ++k) {
    auto item = std::make_unique<PlannedTransferT>();
    item->from_floor = r.floors[k];
    item->to_floor = r.floors[k + 1];
    item->sigma = r.transfer_sigma[k];
    plan.transfers.push_back(std::move(item));
  }
  for (size_t k = 0; k < r.drift_sigma.size(); ++k) {
    auto item = std::make_unique<PlannedDriftT>();
    item->floor = r.floors[k];
    item->sigma = r.drift_sigma[k];
    plan.drifts.push_back(std::move(item));
  }
  return plan;
}

}  // namespace

void PlanNode::run(Context& context) {
  constexpr double kDegree = std::numbers::pi / 180;
  PlanOptions options;
  options.profile = built_in_profile(*profile);
  options.sets = static_cast<int>(*sets);
  options.set_ups_per_marker = static_cast<int>(*set_ups_per_marker);
  options.shared_markers = static_cast<int>(*shared_markers);
  options.largest_range = *largest_range;
  options.largest_incidence = *largest_incidence * kDegree;
  options.steepest_sight = *steepest_sight * kDegree;
  options.tolerance = *tolerance;
  PlatesT layout;
  if (plates) layout = plates.unpack();
  std::vector<PlannedSetUp> places;
  for (const auto& p : set_ups.unpack().points) {
    if (!p->position.allFinite())
      throw std::runtime_error("planned set-up '" + p->id + "' has no complete coordinates; give E, N and H");
    places.push_back({p->id, p->position});
  }
  const PlanResult result = plan_survey(planned_markers(markers.unpack(), plates ? &layout : nullptr), places, options);
  for (const PlannedRule& rule : result.rules)
    if (!rule.holds) context.warn(rule.name + ": " + rule.text);
  for (const std::string& remedy : result.remedies) context.info("remedy " + remedy);
  plan.commit(to_artifact(result));
}

}  // namespace plumbline::survey

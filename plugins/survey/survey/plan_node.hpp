// plan.survey: a planned layout judged before anybody measures.
#pragma once

#include "artifacts/plates.hpp"
#include "artifacts/points.hpp"
#include "artifacts/survey_observations.hpp"
#include "artifacts/survey_plan.hpp"
#include "profiled_node.hpp"

namespace plumbline::survey {

struct PlanNode : ProfiledNode {
  static constexpr Info info{"plan.survey", "", 3,
                             "Checks a planned layout of markers and set-ups and predicts the precision it will give"};
  In<Points> markers{"markers", frame("frame=?S"), "planned coordinates of the markers"};
  Optional<Plates> plates{"plates", frame("frame=?S"),
                          "floor, column and direction of each marker; without: one floor"};
  In<plumbline::SurveyObservations> set_ups{
      "set_ups", frame("frame=?S"),
      "its points are the planned set-ups; observations without value say what each is to "
      "sight, a set-up without any sights all that it can"};
  Param<int64_t> sets{"sets", 1, between(1, 20), "sets in both faces"};
  Param<int64_t> set_ups_per_marker{"set_ups_per_marker", 2, between(1, 10), "set-ups that must see each marker"};
  Param<int64_t> shared_markers{"shared_markers", 2, between(1, 100),
                                "markers of each of two adjacent floors that common set-ups must see"};
  Param<int64_t> markers_per_floor{"markers_per_floor", 6, between(1, 1000), "fewest markers of a floor"};
  Param<double> spacing{"spacing", 2.0, "m", between(0.01, 100), "of the marker grid: to the nearest marker"};
  Param<double> spacing_tolerance{"spacing_tolerance", 0.5, "m", between(0, 100), "how far a spacing may be off"};
  Param<double> largest_range{"largest_range", 60.0, "m", between(1, 1000), "longest sight"};
  Param<double> largest_incidence{"largest_incidence", 60.0, "deg", between(1, 90), "shallowest sight onto a plate"};
  Param<double> steepest_sight{"steepest_sight", 50.0, "deg", between(1, 89), "largest elevation of a sight"};
  Param<double> tolerance{"tolerance", 0.005, "m", between(1e-4, 1), "tolerance that the survey is to judge"};
  Out<SurveyPlan> plan{"plan", frame("frame=?S"), "rules, predicted precision, remedies"};
  void run(Context& context) override;
};

}  // namespace plumbline::survey

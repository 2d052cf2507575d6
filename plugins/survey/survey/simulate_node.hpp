// simulate.survey: readings of a survey that nobody made, with the mistakes one asks for.
#pragma once

#include "artifacts/points.hpp"
#include "artifacts/survey_observations.hpp"
#include "profiled_node.hpp"

namespace plumbline::survey {

struct SimulateSurveyNode : ProfiledNode {
  static constexpr Info info{"simulate.survey", "", 1,
                             "Readings of a total station to markers from planned set-ups, with its noise and with "
                             "the mistakes of the field"};
  In<Points> markers{"markers", frame("frame=?S"), "true coordinates of the markers"};
  In<plumbline::SurveyObservations> set_ups{
      "set_ups", frame("frame=?S"),
      "its points are the set-ups (tilting axis); observations without value say what each sights, in this order; a "
      "set-up without any sights all"};
  Param<int64_t> sets{"sets", 1, between(1, 20), "sets in both faces; readings are their means"};
  Param<double> noise{"noise", 1.0, "1", between(0, 100), "factor on the standard deviations of the profile"};
  Param<bool> coordinates{"coordinates", false, "the points carry their true coordinates as approximate ones"};
  Param<std::vector<std::string>> mistakes{
      "mistakes", std::vector<std::string>{},
      "planted one after another: 'reading S1 M05 distance 0.5' (direction and zenith in gon, distance in m), 'swap S1 "
      "M05 M06', 'name S1 M05 M06', 'circle S1 10 0.5' (gon, from the 10th sight on), 'moved S1 10 0.2' (m), 'prism S1 "
      "0.0344', 'scale S1 1e-4', 'height S1 0.1', 'unit S1 0.3048'"};
  Out<plumbline::SurveyObservations> observations{"observations", frame("frame=?S"), "the readings"};
  void run(Context& context) override;
};

}  // namespace plumbline::survey

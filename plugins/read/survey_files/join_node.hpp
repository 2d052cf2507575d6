// survey.join: readings of several sensors, or of several readers, as one network.
#pragma once

#include "artifacts/points.hpp"
#include "artifacts/survey_observations.hpp"
#include "plumbline/node.hpp"

namespace plumbline::survey_files {

struct JoinSurveys : Node {
  static constexpr Info info{"survey.join", "", 1,
                             "Joins the readings of several files or sensors to those of one network"};
  List<SurveyObservations> readings{"observations", frame("frame=?S"),
                                    "those of one reader each: [campaign.survey, tracker.observations]"};
  Optional<Points> known{"known", frame("frame=?S"),
                         "control points: a set-up on one of them stands on that mark, in whatever file"};
  Out<SurveyObservations> joined{"observations", frame("frame=?S"), "all readings; set-ups are numbered anew"};
  void run(Context& context) override;
};

}  // namespace plumbline::survey_files

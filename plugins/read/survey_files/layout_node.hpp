// read.layout: a planned survey as a table to the inputs of plan.survey.
#pragma once

#include "artifacts/file.hpp"
#include "artifacts/plates.hpp"
#include "artifacts/points.hpp"
#include "artifacts/survey_observations.hpp"
#include "plumbline/node.hpp"

namespace plumbline::survey_files {

struct ReadLayout : Node {
  static constexpr Info info{"read.layout", "", 1, "Reads a table of planned markers and set-ups"};
  In<File> file{"file",
                "CSV with the columns kind, id, east_m, north_m, height_m, floor, column, facing_azimuth_deg, "
                "sees; see docs/epochs.md"};
  Out<Points> markers{"markers", frame("frame=building"), "the planned markers"};
  Out<Plates> plates{"plates", frame("frame=building"), "their floors, columns and directions"};
  Out<SurveyObservations> set_ups{"set_ups", frame("frame=building"),
                                  "the planned set-ups as points, and what they are to sight as observations without "
                                  "value"};
  void run(Context& context) override;
};

}  // namespace plumbline::survey_files

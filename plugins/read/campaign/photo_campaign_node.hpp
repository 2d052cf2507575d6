// read.photo_campaign: photographs and a survey of their tags, without a design.
#pragma once

#include "artifacts/camera.hpp"
#include "artifacts/folder.hpp"
#include "artifacts/image.hpp"
#include "artifacts/input_files.hpp"
#include "artifacts/plates.hpp"
#include "artifacts/points.hpp"
#include "artifacts/survey_artifact.hpp"
#include "artifacts/survey_readings.hpp"
#include "plumbline/node.hpp"

namespace plumbline::campaign {

struct ReadPhotoCampaign : Node {
  static constexpr Info info{"read.photo_campaign", "", 4,
                             "Reads photographs and the survey of their tags: a campaign without a design"};
  In<Folder> folder{"folder", "a folder with photographs and survey files or control points; docs/photographs.md"};
  Optional<SurveyReadings> added{"readings", frame("frame=building"),
                                 "survey files that readers of other plugins have read: parts/readers.yaml"};
  OutList<Image> images{"images", "the photographs, by reference, ordered by path"};
  OutList<Camera> cameras{"cameras", "the calibrations, where the folder has any"};
  Out<Plates> plates{"plates", frame("frame=building"), "which tag stands for which point; empty: names tell"};
  Out<SurveyObservations> survey{"survey", frame("frame=building"),
                                 "all survey files in one; without any, the control points as measured coordinates"};
  Out<Points> control{"control", frame("frame=building"), "the control points that the survey hangs on"};
  Param<bool> strict{"strict", true,
                     "refuse survey files of which anything has to be skipped; otherwise it is a warning"};
  Out<InputFiles> inputs{"inputs", "the files that were read, and evidence that `unused` sets aside"};
  Out<InputFiles> unread{"unread", "what else lies in the folder"};

  void run(Context& context) override;
};

}  // namespace plumbline::campaign

// campaign.propose and campaign.account: what `plumbline campaign init` and `check` say.
#pragma once

#include "artifacts/element_matches.hpp"
#include "artifacts/file.hpp"
#include "artifacts/folder.hpp"
#include "artifacts/input_files.hpp"
#include "artifacts/plates.hpp"
#include "artifacts/points.hpp"
#include "artifacts/survey_observations.hpp"
#include "artifacts/survey_readings.hpp"
#include "plumbline/node.hpp"

namespace plumbline::campaign {

struct ProposeCampaign : Node {
  static constexpr Info info{"campaign.propose", "", 3, "Proposes a campaign.yaml for what lies in a folder"};
  In<Folder> folder{"folder", "a folder with photographs, survey files, tables and a design"};
  Optional<SurveyReadings> readings{"readings", frame("frame=building"),
                                    "survey files that readers of other plugins know as theirs: parts/readers.yaml"};
  Out<File> description{"campaign", "campaign.yaml with a comment behind each line; what is missing is a comment"};
  Out<File> summary{"summary", "what was recognised, and what has to be mended, as text"};
  Out<File> pipeline{"pipeline",
                     "name of the pipeline that the folder is whole for, where that is none of a site with "
                     "photographs of tags; empty: none"};
  void run(Context& context) override;
};

struct AccountForCampaign : Node {
  static constexpr Info info{"campaign.account", "", 7,
                             "Says which files of a campaign's folder take part, and what a run will assume"};
  In<InputFiles> inputs{"inputs", "the files that were read, and what was set aside"};
  In<InputFiles> unread{"unread", "what else lies in the folder"};
  Optional<SurveyObservations> survey{"survey", frame("frame=building"),
                                      "the survey as read: instruments of which there is no profile are told"};
  Optional<Points> control{"control", frame("frame=building"),
                           "the control points as given: what they are called is "
                           "held against the readings"};
  Optional<Plates> plates{"plates", frame("frame=building"), "the plates: likewise their anchors, and their tags"};
  Optional<ElementMatches> matches{"matches", frame("frame=building"),
                                   "which anchor is which element of the design: what neither the readings nor the "
                                   "design know is wrong"};
  Param<std::vector<std::string>> families{"families", std::vector<std::string>{"tag36h11"},
                                           "tags that the run looks for: others in the plate table are wrong"};
  Out<File> summary{"summary", "a few lines of text"};
  Out<File> pipeline{"pipeline", "name of the pipeline that takes the folder"};
  void run(Context& context) override;
};

}  // namespace plumbline::campaign

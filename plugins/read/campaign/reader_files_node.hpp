// campaign.files_for: survey files of a campaign to a reader of another plugin; pipelines/parts/readers.yaml.
#pragma once

#include "artifacts/file.hpp"
#include "artifacts/folder.hpp"
#include "artifacts/survey_readings.hpp"
#include "plumbline/node.hpp"

namespace plumbline::campaign {

/// What an optional port holds; nothing where it is not connected.
template <typename OptionalPort>
SurveyReadingsT given_by(const OptionalPort& port) {
  return port ? port.unpack() : SurveyReadingsT();
}

struct FilesForReader : Node {
  static constexpr Info info{"campaign.files_for", "", 1,
                             "Gives a reader those of the survey files which campaign.yaml names that are its own"};
  In<Folder> folder{"folder", "the folder of a campaign"};
  Param<std::string> reader{"reader", required, "kind of the reader"};
  Param<std::vector<std::string>> files{"files", required, "names of the files that it reads, such as *.trk"};
  OutList<File> taken{"files", "its files, ordered by path, which is their name"};
  Out<SurveyReadings> offered{"offered", frame("frame=building"),
                              "which files those are, and which of its own nothing names"};
  void run(Context& context) override;
};

}  // namespace plumbline::campaign

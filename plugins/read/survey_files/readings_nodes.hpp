// Survey files that readers of other plugins read: pipelines/parts/readers.yaml, file_reader.yaml. A reader takes part
// by its role and by a parameter `files` that says which files are its own.
#pragma once

#include "artifacts/file.hpp"
#include "artifacts/survey_readings.hpp"
#include "plumbline/node.hpp"

namespace plumbline::survey_files {

/// For a pipeline that takes one file; campaign.files_for does it for a folder.
struct FileForReader : Node {
  static constexpr Info info{"survey.file_for", "", 1, "Gives a survey file to a reader, if it is one of its own"};
  In<File> file{"file", "a survey file"};
  Param<std::string> reader{"reader", required, "kind of the reader"};
  Param<std::vector<std::string>> files{"files", required, "names of the files that it reads, such as *.trk"};
  OutList<File> taken{"files", "the file, if the reader reads such"};
  Out<SurveyReadings> offered{"offered", frame("frame=building"), "which files it gets"};
  void run(Context& context) override;
};

struct CollectReadings : Node {
  static constexpr Info info{"survey.collect", "", 1,
                             "Puts what readers of other plugins have read together with the files that it is from"};
  List<SurveyReadings> offered{"offered", frame("frame=building"), "which files each reader got"};
  List<SurveyObservations> observations{"observations", frame("frame=building"),
                                        "what they read of them, each of the one file that it names"};
  Out<SurveyReadings> readings{"readings", frame("frame=building"), "all of it, each file by itself"};
  void run(Context& context) override;
};

}  // namespace plumbline::survey_files

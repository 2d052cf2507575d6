// report.sheets: a sheet of paper for each facade and floor.
#pragma once

#include "artifacts/design.hpp"
#include "artifacts/deviation.hpp"
#include "artifacts/file.hpp"
#include "artifacts/survey_observations.hpp"
#include "plumbline/node.hpp"
#include "show/report/language.hpp"
#include "show/report/sheets_page.hpp"

namespace plumbline::report {

struct ReportSheets : Node {
  static constexpr Info info{
      "report.sheets", "", 1,
      "Sheets to print, one for each facade and floor: elevation, what is to be done, room to sign"};
  In<Deviation> deviation{"deviation", frame("frame=?F"), "as-built minus design, judged"};
  Optional<Design> design{"design", frame("frame=?F"), "the design, for its grid"};
  Optional<SurveyObservations> survey{"survey", frame("frame=?S"), "the survey as read: its title, its date"};
  Param<std::string> title{"title", "Facade anchors", "heading"};
  Param<std::string> language{"language", "en", one_of("en", "de"), "of the sheets"};
  Param<std::string> units{"units", "mm", one_of("mm", "in"), "of lengths on them; data files keep theirs"};
  Out<File> out{"file", "sheets.html"};

  void run(Context&) override {
    const Speaking speaking(speech_of(*language, *units));
    ReportInput input;
    input.title = *title;
    input.deviation = deviation.unpack();
    input.accuracy.tau = input.deviation->tau;
    if (design) input.grid = ifc::grid_of(design.unpack());
    if (survey && survey->info()) {
      SurveyInfoT info_of_survey;
      survey->info()->UnPackTo(&info_of_survey);
      input.subtitle = info_of_survey.title;
      if (!info_of_survey.date.empty()) input.subtitle += (input.subtitle.empty() ? "" : ", ") + info_of_survey.date;
    }
    FileT file;
    file.name = "sheets.html", file.media_type = "text/html";
    const std::string html = render_sheets(input);
    file.content.assign(html.begin(), html.end());
    out.commit(file);
  }
};

}  // namespace plumbline::report

// report.survey: a page of its own for a survey network, a plan, or two epochs.
#pragma once

#include "artifacts/file.hpp"
#include "artifacts/input_files.hpp"
#include "artifacts/points.hpp"
#include "artifacts/survey_comparison.hpp"
#include "artifacts/survey_network.hpp"
#include "artifacts/survey_plan.hpp"
#include "plumbline/node.hpp"
#include "show/report/report.hpp"

namespace plumbline::report {

struct ReportSurvey : Node {
  static constexpr Info info{"report.survey", "", 4,
                             "One offline HTML file about a survey: plan, network, control points, epochs"};
  Optional<SurveyPlan> plan{"plan", frame("frame=?F"), "a judged plan"};
  Optional<SurveyComparison> epochs{"epochs", frame("frame=?F"), "two epochs compared"};
  Optional<SurveyNetwork> network{"network", frame("frame=?F"), "an adjusted network"};
  Optional<SurveyComparison> control_check{"control_check", frame("frame=?F"),
                                           "the control points tested against the network"};
  Optional<SurveyNetwork> in_file_axes{"in_file_axes", frame("frame=?X"),
                                       "the same network in the axes of its file, for the table of coordinates"};
  Optional<Points> points{"points", frame("frame=?F"),
                          "its points with covariance, for what neighbours are known relative to each other"};
  Optional<InputFiles> inputs{"inputs", "the files that were read, and what was set aside, for the end of the page"};
  Optional<InputFiles> unread{"unread", "what else lay in the folder, for the end of the page"};
  Param<std::string> title{"title", "Survey", "heading"};
  Param<std::string> subtitle{"subtitle", "", "site and date"};
  Param<std::string> name{"name", "survey.html", "name of the file"};
  Param<std::string> pipeline{
      "pipeline", "",
      "what ran, for the end of the page: a line 'node: kind parameter=value' for each node, as "
      "${pipeline} gives it"};
  Param<std::string> language{"language", "en", one_of("en", "de"), "of the page"};
  Param<std::string> units{"units", "mm", one_of("mm", "in"), "of lengths on the page; data files keep theirs"};
  Out<File> out{"file", "the page"};
  void run(Context& context) override;

 private:
  NetworkPage page_of_network() const;
};

}  // namespace plumbline::report

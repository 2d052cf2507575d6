// report.installation: the page of an execution loop.
#pragma once

#include <map>

#include "artifacts/file.hpp"
#include "artifacts/input_files.hpp"
#include "artifacts/installation_plan.hpp"
#include "artifacts/loop_state.hpp"
#include "artifacts/survey_comparison.hpp"
#include "artifacts/survey_network.hpp"
#include "plumbline/node.hpp"

namespace plumbline::report {

struct ReportInstallation : Node {
  static constexpr Info info{
      "report.installation", "", 4,
      "One offline HTML file about an execution loop: what to do next by floor and robot, states "
      "over rounds, what was done again and why"};
  In<InstallationPlan> plan{"plan", frame("frame=?F"), "the plan of the last round"};
  In<LoopState> state{"state", frame("frame=?F"), "the state after it"};
  Optional<SurveyNetwork> network{"network", frame("frame=?S"), "the survey that the plan rests on, for a section"};
  Optional<SurveyComparison> control_check{"control_check", frame("frame=?S"),
                                           "the control points tested against it, for a warning"};
  Optional<InputFiles> inputs{"inputs", "the files that were read, for the end of the page"};
  Optional<InputFiles> unread{"unread", "what else lay in the folder, for the end of the page"};
  Param<std::string> title{"title", "Installation of the facade", "heading"};
  Param<std::string> subtitle{"subtitle", "", "site and date"};
  Param<std::vector<std::string>> robots{"robots", std::vector<std::string>{},
                                         "which robot works where: '3=robot-b', a floor each"};
  Param<std::string> name{"name", "loop.html", "name of the file"};
  Param<std::string> pipeline{"pipeline", "", "what ran, for the end of the page, as ${pipeline} gives it"};
  Param<std::string> language{"language", "en", one_of("en", "de"), "of the page"};
  Param<std::string> units{"units", "mm", one_of("mm", "in"), "of lengths on the page; data files keep theirs"};
  Out<File> out{"file", "the page"};
  void run(Context& context) override;

 private:
  std::map<int, std::string> robots_by_floor() const;
};

}  // namespace plumbline::report

#include "show/report/installation_page_node.hpp"

#include "artifacts/input_files_text.hpp"
#include "show/report/installation_page.hpp"
#include "show/report/language.hpp"
#include "show/report/network_page.hpp"
#include "show/report/sections.hpp"

namespace plumbline::report {

std::map<int, std::string> ReportInstallation::robots_by_floor() const {
  std::map<int, std::string> by_floor;
  for (const std::string& text : *robots) {
    const auto equals = text.find('=');
    char* end = nullptr;
    const long floor = std::strtol(text.c_str(), &end, 10);
    if (equals == std::string::npos || end != text.c_str() + equals || equals == 0 || equals + 1 == text.size())
      throw std::runtime_error("parameter 'robots': '" + text + "' is not of the form floor=robot, such as 3=robot-b");
    by_floor[static_cast<int>(floor)] = text.substr(equals + 1);
  }
  return by_floor;
}

void ReportInstallation::run(Context&) {
  const Speaking speaking(speech_of(*language, *units));
  const InstallationPlanT planned = plan.unpack();
  const LoopStateT reached = state.unpack();
  const auto by_floor = robots_by_floor();
  SurveyComparisonT control;
  if (control_check) control = control_check.unpack();
  const std::string page = render_page(title_spoken(*title), [&](Markup& html) {
    Scope main(html, "main");
    {
      Scope header(html, "header");
      html.element("h1", title_spoken(*title));
      if (!subtitle->empty()) html.element("p", {{"class", "subtitle"}}, verbatim(*subtitle));
      if (control_check) write_control_warning(html, control);
    }
    write_next(html, planned, reached, by_floor);
    write_refused(html, reached);
    write_rounds(html, planned, reached);
    write_items(html, planned, reached);
    if (network) write_network(html, network_page(network.unpack()), control_check ? &control : nullptr);
    ReportInput run;
    add_input_files(inputs ? inputs.unpack() : InputFilesT(), unread ? unread.unpack() : InputFilesT(),
                    used_of(network), run);
    run.provenance.emplace_back("Plan rests on", "measurement " + planned.basis);
    run.provenance.emplace_back("Program", std::string("Plumbline ") + PLUMBLINE_BUILD_ID);
    add_nodes(*pipeline, run.provenance);
    write_provenance(html, run);
  });
  FileT file;
  file.name = *name, file.media_type = "text/html";
  file.content.assign(page.begin(), page.end());
  out.commit(file);
}

}  // namespace plumbline::report

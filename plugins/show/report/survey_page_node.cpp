#include "show/report/survey_page_node.hpp"

#include "artifacts/input_files_text.hpp"
#include "artifacts/joint_memory.hpp"
#include "show/report/language.hpp"
#include "show/report/network_page.hpp"
#include "show/report/sections.hpp"

namespace plumbline::report {

NetworkPage ReportSurvey::page_of_network() const {
  SurveyNetworkT file_axes;
  if (in_file_axes) file_axes = in_file_axes.unpack();
  PointsT all;
  if (points) all = points.unpack();
  return network_page(network.unpack(), in_file_axes ? &file_axes : nullptr, points ? &all : nullptr);
}

void ReportSurvey::run(Context& context) {
  announce_joint(context, joint_size(points), 4);
  const Speaking speaking(speech_of(*language, *units));
  if (!plan && !epochs && !network)
    throw std::runtime_error("none of the inputs plan, epochs and network is connected");
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
    if (plan) write_plan(html, plan.unpack());
    if (epochs) write_epochs(html, epochs.unpack());
    if (network) write_network(html, page_of_network(), control_check ? &control : nullptr);
    if (!pipeline->empty() || inputs) {
      ReportInput run;
      add_input_files(inputs ? inputs.unpack() : InputFilesT(), unread ? unread.unpack() : InputFilesT(),
                      used_of(network), run);
      run.provenance.emplace_back("Program", std::string("Plumbline ") + PLUMBLINE_BUILD_ID);
      add_nodes(*pipeline, run.provenance);
      write_provenance(html, run);
    }
  });
  FileT file;
  file.name = *name, file.media_type = "text/html";
  file.content.assign(page.begin(), page.end());
  out.commit(file);
}

}  // namespace plumbline::report

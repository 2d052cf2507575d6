#include "show/report/calibration_page_node.hpp"

#include <nlohmann/json.hpp>

#include "show/report/calibration_page.hpp"
#include "show/report/language.hpp"
#include "show/report/sections.hpp"

namespace plumbline::report {

void ReportCalibration::run(Context&) {
  const Speaking speaking(speech_of(*language, *units));
  const auto* content = calibration->content();
  const auto json = nlohmann::ordered_json::parse(content->begin(), content->end(), nullptr, false);
  if (json.is_discarded() || !json.is_object() || (!json.contains("parameters") && !json.contains("cameras")))
    throw std::runtime_error("the input 'calibration' is not a calibration.json: 'parameters' or 'cameras' is missing");
  const std::string page =
      render_page(title_spoken(*title), [&](Markup& html) { write_calibration(html, json, *title, *subtitle); });
  FileT file;
  file.name = *name, file.media_type = "text/html";
  file.content.assign(page.begin(), page.end());
  out.commit(file);
}

}  // namespace plumbline::report

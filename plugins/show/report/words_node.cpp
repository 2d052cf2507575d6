#include "show/report/words_node.hpp"

#include <stdexcept>

#include "show/report/language.hpp"
#include "show/report/spoken_texts.hpp"

namespace plumbline::report {

void ReportWords::run(Context&) {
  const Speaking speaking(speech_of(*language, *units));
  FileT file = text.unpack();
  const bool page = file.media_type == "text/html";
  if (page && speech().units != Units::millimetres)
    throw std::runtime_error("'text' is a page, whose tables stay in mm: units=in would name another unit beside them");
  if (!speech().plain()) {
    const std::string english(file.content.begin(), file.content.end());
    const std::string said = page ? spoken_page(english) : *comments ? spoken_comments(english) : spoken_lines(english);
    file.content.assign(said.begin(), said.end());
  }
  out.commit(file);
}

}  // namespace plumbline::report

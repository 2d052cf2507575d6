#include "show/report/words_node.hpp"

#include "show/report/language.hpp"
#include "show/report/summary.hpp"

namespace plumbline::report {

void ReportWords::run(Context&) {
  const Speaking speaking(speech_of(*language, *units));
  FileT file = text.unpack();
  if (!speech().plain()) {
    const std::string said = spoken_lines({file.content.begin(), file.content.end()});
    file.content.assign(said.begin(), said.end());
  }
  out.commit(file);
}

}  // namespace plumbline::report

// The whole command that mends what speaks against the measurement, to be pasted.
#include <string>
#include <utility>
#include <vector>

#include "base/text/shell_word.hpp"
#include "show/report/language.hpp"
#include "show/report/sections.hpp"

namespace plumbline::report {

namespace {

/// A value that somebody has to find out first stands in the note ("frames.with.datum_sigma=0.005 where ...").
bool takes_a_value(const MeasurementDoubtT& finding) {
  return finding.mend.empty() && finding.part == MeasurementPart::datum;
}

bool has_facade_to_confirm(const DeviationT& deviation) {
  for (const auto& facade : deviation.facades)
    if (!facade->confirmed) return true;
  return false;
}

}  // namespace

void write_commands(Markup& html, const ReportInput& input) {
  if (!input.deviation || input.command.empty()) return;
  const DeviationT& deviation = *input.deviation;
  std::vector<const MeasurementDoubtT*> whole;
  bool others = has_facade_to_confirm(deviation);
  for (const auto* findings : {&deviation.doubts, &deviation.misfits})
    for (const auto& finding : *findings) {
      if (!finding->mend.empty()) whole.push_back(finding.get());
      others = others || takes_a_value(*finding);
    }
  for (const auto& request : deviation.requests) others = others || !request->not_judged.empty();
  if (whole.empty() && !others) return;
  Scope box(html, "div", {{"class", "warnings"}, {"id", "commands"}});
  html.element("h2", "What to type to run it again");
  for (const MeasurementDoubtT* finding : whole) {
    html.element("p", finding->mend_note.empty() ? "To mend it:" : "To mend it (" + finding->mend_note + "):");
    html.element("pre", {{"class", "command"}}, verbatim(input.command + " " + text::shell_word(finding->mend)));
  }
  if (!others) return;
  html.element("p", "What else is named to be set stands behind this command, with its value:");
  html.element("pre", {{"class", "command"}}, verbatim(input.command));
}

}  // namespace plumbline::report

#include "held_together.hpp"

#include <algorithm>

#include "base/text/words.hpp"
#include "survey/start/alike_names.hpp"
#include "survey/start/measured_names.hpp"

namespace plumbline::campaign {

void hold_control(const survey::SurveyObservations& survey, const std::vector<std::string>& known, Context& context,
                  std::vector<std::string>& problems) {
  const std::set<std::string> measured = survey::measured_names(survey);
  const auto is_measured = [&](const std::string& id) { return measured.contains(id); };
  const bool none = !known.empty() && std::none_of(known.begin(), known.end(), is_measured);
  if (none)
    problems.push_back("none of the control points (" + text::join(known, 8) + ") is in the readings, which have " +
                       text::join({measured.begin(), measured.end()}, 8) +
                       ": is the control that of this site? Names have to be the same, or nothing holds the survey");
  for (const survey::Finding& finding : survey::examine_known_names(survey, known)) {
    if (finding.severity != survey::Finding::Severity::warning) continue;
    if (none)
      problems.push_back(finding.text);
    else
      context.warn(finding.text);
  }
}

void hold_anchors(const PlatesT& plates, const std::set<std::string>& surveyed, const std::set<std::string>& designed,
                  Context& context, std::vector<std::string>& problems) {
  std::vector<std::string> nowhere, unsurveyed;
  for (const auto& plate : plates.plates)
    if (plate->role != "tie" && !surveyed.contains(plate->anchor))
      (designed.contains(plate->anchor) ? unsurveyed : nowhere).push_back(plate->anchor);
  if (!nowhere.empty())
    problems.push_back("neither the readings, nor the control, nor the design have these anchors of the plate table: " +
                       text::join(nowhere, 8) +
                       "; they hold nothing, and nothing can be said of them. Measure them, or write their names the "
                       "same way; marks that only tie photographs have the role 'tie'");
  if (!unsurveyed.empty())
    context.warn("neither the readings nor the control have these anchors of the plate table: " +
                 text::join(unsurveyed, 8) + "; photographs alone measure them, and nothing checks that");
}

void hold_families(const PlatesT& plates, const std::vector<std::string>& looked_for,
                   std::vector<std::string>& problems) {
  std::set<std::string> others;
  for (const auto& plate : plates.plates)
    if (!plate->tag_family.empty() &&
        std::find(looked_for.begin(), looked_for.end(), plate->tag_family) == looked_for.end())
      others.insert(plate->tag_family);
  if (others.empty()) return;
  const std::string list = text::join({others.begin(), others.end()}, 8);
  problems.push_back("the plate table has tags of " + list + ", and a run looks for " + text::join(looked_for, 8) +
                     " alone: correct the table, or tell the run (tags.with.families=[" + list + "]) and this check (" +
                     (others.size() == 1
                          ? "family=" + list
                          : "campaign.with.families=[" + list + "] account.with.families=[" + list + "]") +
                     ")");
}

}  // namespace plumbline::campaign

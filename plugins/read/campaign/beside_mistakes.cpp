#include "beside_mistakes.hpp"

#include <set>

#include "held_together.hpp"
#include "survey/start/measured_names.hpp"
#include "unused_files.hpp"
#include "whole_design.hpp"

namespace plumbline::campaign {
namespace {

/// Anchors that no file has, where readings, control and design could be read. Which element an anchor is only the
/// reader of the design knows; what stands nowhere in it is none.
void look_at_anchors(const ListedCampaign& site, const PlatesT& plates, const survey::SurveyObservations& readings,
                     const std::vector<std::string>& known, Context& context, std::vector<std::string>& wrong) {
  const CampaignDescription& given = site.description;
  if (plates.plates.empty() || given.design.empty() || !given.mapping.empty()) return;
  if (!given.control.empty() && known.empty()) return;
  std::set<std::string> surveyed = survey::measured_names(readings), anchors;
  surveyed.insert(known.begin(), known.end());
  for (const auto& plate : plates.plates) anchors.insert(plate->anchor);
  const std::set<std::string> designed = names_that_may_be_in(site.root / given.design, anchors);
  hold_anchors(plates, surveyed, designed, context, wrong);
}

}  // namespace

void look_at_design(ListedCampaign& site) {
  if (site.problems.empty() || site.description.design.empty()) return;
  const std::filesystem::path design = site.root / site.description.design;
  site.problems.attempt([&] { require_whole_design(design, design); });
}

void look_at_what_belongs_together(ListedCampaign& site, const PlatesT& plates,
                                   const std::vector<ControlPoint>& control, const SurveyObservationsT& readings,
                                   const std::vector<std::string>& families, Context& context) {
  if (site.problems.empty()) return;
  std::vector<std::string> wrong, known;
  for (const ControlPoint& point : control) known.push_back(point.name);
  if (!readings.observations.empty()) {  // of files with mistakes there is nothing, not even what an artifact must have
    const survey::SurveyObservations survey = survey::from_artifact(readings);
    hold_control(survey, known, context, wrong);
    look_at_anchors(site, plates, survey, known, context, wrong);
  }
  if (site.description.observations.empty()) hold_families(plates, families, wrong);
  if (const auto names = forgotten_control(site.unused); !names.empty())
    wrong.push_back(words_of_forgotten_control(names));
  for (const std::string& problem : wrong) site.problems.add(CampaignError(problem));
}

}  // namespace plumbline::campaign

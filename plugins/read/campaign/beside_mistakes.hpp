// What is told beside other mistakes of a campaign's folder, though its own node does not run then: all at once.
#pragma once

#include <string>
#include <vector>

#include "artifacts/plates.hpp"
#include "artifacts/survey_artifact.hpp"
#include "control/points/control_point.hpp"
#include "listed_campaign.hpp"

namespace plumbline::campaign {

/// Beside other mistakes, which keep the design from being read; where it is the only one, its reader says so, and what
/// needs no design goes on.
void look_at_design(ListedCampaign& site);

/// Beside other mistakes, as the design: where a folder has no others, campaign.account tells these. `families`: tags
/// that a run looks for.
void look_at_what_belongs_together(ListedCampaign& site, const PlatesT& plates,
                                   const std::vector<ControlPoint>& control, const SurveyObservationsT& readings,
                                   const std::vector<std::string>& families, Context& context);

}  // namespace plumbline::campaign

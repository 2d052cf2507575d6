// The parts of a campaign's folder held against each other: each may be whole by itself, and nothing comes of them
// together. What a run would miss is a problem, what it goes on with a warning of the node.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "artifacts/plates.hpp"
#include "plumbline/node.hpp"
#include "survey/model/survey_observations.hpp"

namespace plumbline::campaign {

/// Known points that nothing measured, or whose names are written otherwise there: what the run would miss of them.
/// Names that are alike may be two marks: as long as other control is measured that is for a person to look at.
void hold_control(const survey::SurveyObservations& survey, const std::vector<std::string>& known, Context& context,
                  std::vector<std::string>& problems);

/// Anchors of the plate table that are in no other file. A table whose names are nowhere else is whole by itself, and
/// the run goes on without them.
void hold_anchors(const PlatesT& plates, const std::set<std::string>& surveyed, const std::set<std::string>& designed,
                  Context& context, std::vector<std::string>& problems);

/// Tags of the plate table that the run does not look for. Detectors look for one family unless they are told.
void hold_families(const PlatesT& plates, const std::vector<std::string>& looked_for,
                   std::vector<std::string>& problems);

}  // namespace plumbline::campaign

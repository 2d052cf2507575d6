// The survey files of a campaign as one set of observations.
#pragma once

#include <string>
#include <vector>

#include "formats/survey_observations.hpp"

namespace plumbline::campaign {

/// Reads one survey file by the end of its name. Throws survey::SurveyReadError, and CampaignError for another ending.
survey::SurveyObservations read_survey_file(const std::string& bytes, const std::string& shown);

/// All observations in one, indices shifted; a point that several files give keeps its first coordinates.
survey::SurveyObservations merge(const std::vector<survey::SurveyObservations>& parts);

}  // namespace plumbline::campaign

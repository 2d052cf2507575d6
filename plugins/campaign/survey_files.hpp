// The survey files of a campaign as one set of observations.
#pragma once

#include <vector>

#include "survey/model/survey_observations.hpp"

namespace plumbline::campaign {

/// All observations in one, indices shifted; a point that several files give keeps its first coordinates.
survey::SurveyObservations merge(const std::vector<survey::SurveyObservations>& parts);

}  // namespace plumbline::campaign

// Which points of a survey something was measured of.
#pragma once

#include <set>
#include <string>

#include "survey/model/survey_observations.hpp"

namespace plumbline::survey {

/// Points that something was measured to, from or of, but for known coordinates.
std::set<std::string> measured_names(const SurveyObservations& survey);

}  // namespace plumbline::survey

// One name for two free stations in one file: the instrument was put up elsewhere and the name kept.
#pragma once

#include <string>
#include <vector>

#include "survey/model/adjust_options.hpp"
#include "survey/model/survey_observations.hpp"

namespace plumbline::survey {

/// Gives set-ups a station of their own whose shared targets put them elsewhere than the first set-up of their station,
/// beyond doubt. A station that is known, held, or sighted as a target is one mark whatever its set-ups see.
std::vector<Finding> part_stations(SurveyObservations& survey, const std::vector<std::string>& known);

}  // namespace plumbline::survey

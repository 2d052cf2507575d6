// What takes no part in an adjustment: by the user's wish, or because nothing determines it.
#pragma once

#include <string>
#include <vector>

#include "survey/adjust/adjust_network.hpp"

namespace plumbline::survey {

/// The survey without what is excluded; each exclusion becomes a finding with its reason and the number of readings it
/// cost. Throws NetworkError if one names something that is not there, neither in the survey nor in its control.
SurveyObservations without_excluded(const SurveyObservations& survey, const std::vector<ExcludedItem>& exclude,
                                    const ControlPoints& control, std::vector<Finding>& findings);
/// The control without what is excluded of it.
ControlPoints without_excluded(const ControlPoints& control, const std::vector<ExcludedItem>& exclude);

/// The survey without these points and everything observed to, from or of them.
SurveyObservations without_points(const SurveyObservations& survey, const std::vector<std::string>& points);

}  // namespace plumbline::survey

// What takes no part in an adjustment: by the user's wish, or because nothing determines it.
#pragma once

#include <string>
#include <vector>

#include "survey/adjust/adjust_network.hpp"

namespace plumbline::survey {

/// The survey without what is excluded; each exclusion becomes a finding with its reason and the number of readings it
/// cost. Throws NetworkError if one names something that is not there.
SurveyObservations without_excluded(const SurveyObservations& survey, const std::vector<ExcludedItem>& exclude,
                                    std::vector<Finding>& findings);

/// The survey without these points and everything observed to, from or of them.
SurveyObservations without_points(const SurveyObservations& survey, const std::vector<std::string>& points);

}  // namespace plumbline::survey

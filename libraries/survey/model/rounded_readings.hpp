// The readings of one set-up in two files of which one shows fewer digits: a job file and a table made from it.
#pragma once

#include <vector>

#include "survey/model/survey_observations.hpp"

namespace plumbline::survey {

/// Readings of a set-up in the order of their targets, kinds, faces and values.
std::vector<const Observation*> in_order(const SurveyObservations& survey, int set_up);

enum class Rounded { no, first_is_coarser, second_is_coarser };

/// Whether two sets of readings, in_order(), are the same to within the digits that they are written in, and no
/// coincidence: a target read again on a circle that was set to zero again comes out alike in coarse digits.
Rounded same_when_rounded(const std::vector<const Observation*>& first, const std::vector<const Observation*>& second);

}  // namespace plumbline::survey

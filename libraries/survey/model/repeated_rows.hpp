// What stands twice in one survey, or in several that were united: rows that were pasted twice, the block of known
// points that every day's file begins with, GNSS vectors of a file and of its copy.
#pragma once

#include "survey/model/adjust_options.hpp"
#include "survey/model/survey_observations.hpp"

namespace plumbline::survey {

/// Takes out sights of one set-up (or of none: lines, single distances) that repeat an earlier one to the last digit,
/// where that is no coincidence; known and measured coordinates of the same points with the same values and covariance;
/// and vectors likewise. Says what was taken out: known points that several files hold are a note.
std::vector<Finding> take_out_repeated_rows(SurveyObservations& survey);

}  // namespace plumbline::survey

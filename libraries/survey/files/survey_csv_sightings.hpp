// What a table of sightings must not pass over in silence: columns with a known name that it does not use, and cells
// left empty in a column of heights. Read as no height, they are 0 m, and every point is wrong by a pole.
#pragma once

#include "survey/files/survey_csv_columns.hpp"

namespace plumbline::survey {

/// Throws SurveyReadError where a column may be a height or an angle of the sightings, or where a height is missing
/// that other rows have; warns of other columns that are left out.
void check_sightings(const text::CsvTable& table, SurveyColumns& columns, SurveyBuilder& builder);

}  // namespace plumbline::survey

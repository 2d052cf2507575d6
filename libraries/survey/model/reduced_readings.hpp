// Readings that an adjustment program's own file has freed from the earth's curvature and from refraction. A file says
// it by its format; where files become one network each of its readings says it, so that no other is taken for one.
#pragma once

#include <algorithm>
#include <string>

#include "survey/model/survey_observations.hpp"

namespace plumbline::survey {

/// Stands in `corrections` of a reading that came from such a file into a network of several formats.
inline constexpr const char* kReducedBefore =
    "free of curvature and refraction, as its file is an adjustment program's";

inline bool is_of_adjustment_program(const NetworkInfo& info) {
  return info.format == "gama-xml" || info.format == "krumm";
}

inline bool is_reduced(const Observation& o) {
  return std::find(o.corrections.begin(), o.corrections.end(), kReducedBefore) != o.corrections.end();
}

/// Nothing in it is as an instrument read it.
inline bool is_of_adjustment_programs(const SurveyObservations& survey) {
  if (is_of_adjustment_program(survey.info)) return true;
  return !survey.observations.empty() && survey.local_coordinates.empty() &&
         std::all_of(survey.observations.begin(), survey.observations.end(), is_reduced);
}

}  // namespace plumbline::survey

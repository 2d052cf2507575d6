// Whether a station of one file and the station of the same name in another stand on the same mark.
#pragma once

#include <string>

#include "survey/model/survey_observations.hpp"

namespace plumbline::survey {

struct StationEvidence {
  bool same = false;
  std::string reason;    ///< in words, for either verdict
  bool decided = false;  ///< by measurement: nothing else can overrule it
};

/// By what both see: targets of the same names, with direction and horizontal distance from either station, must be the
/// same figure after a turn about the station alone. Decided with two or more shared targets: the same if most of them
/// agree within 15 mm (and at least two), different otherwise.
StationEvidence compare_figures(const SurveyObservations& a, const SurveyObservations& b, const std::string& station);

/// By what the files say: both hold it as datum, both sight it as a target, or both give it the same coordinates within
/// 1 cm that are not round to the metre (1000, 1000 is where anybody's local job begins).
StationEvidence compare_marks(const SurveyObservations& a, const SurveyObservations& b, const std::string& station);

}  // namespace plumbline::survey

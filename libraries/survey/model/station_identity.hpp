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

/// How far two set-ups of one file stand apart by what both see [m]: a turn and a shift brings most of their shared
/// targets, and at least three, onto each other within 15 mm. NaN where they share too few, or these are no figure.
struct Apart {
  double distance = kNotGiven, sigma = 0;
};
Apart how_far_apart(const SurveyObservations& survey, int set_up, int other);

}  // namespace plumbline::survey

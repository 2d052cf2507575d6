// Raw readings to the observations that are adjusted: face 2 reduced to face 1, means over faces and sets.
#pragma once

#include <string>
#include <vector>

#include "survey/model/survey_observations.hpp"

namespace plumbline::survey {

/// One observation of the adjustment. `observation.value` is the mean, in face 1.
struct MeanObservation {
  Observation observation;
  int sets = 1;              ///< sets in the mean (face pairs, or single readings)
  bool single_face = false;  ///< at least one set has one face only
  double spread = 0;         ///< empirical standard deviation of one set [rad or m]; 0 with one set
  std::vector<int> members;  ///< indices of the readings
};

struct MeanResult {
  std::vector<MeanObservation> observations;
  std::vector<std::string> notes;  ///< what was found odd, e.g. readings that differ by more than they should
};

/// Readings with their own sigma, or in a covariance, stay as they are; all others of one set-up, kind, target and
/// target height become one mean. Sets whose circle was turned in between (constant offset of all directions) are
/// brought onto the first.
MeanResult mean_observations(const SurveyObservations& survey);

}  // namespace plumbline::survey

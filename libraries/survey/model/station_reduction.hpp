// Raw readings to the observations that are adjusted: face 2 reduced to face 1, readings tested among themselves, means
// over faces and sets.
#pragma once

#include <string>
#include <vector>

#include "survey/model/reading_tests.hpp"
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

/// A reading that the others of its target contradict; it is in no mean.
struct RemovedReading {
  int observation = -1;
  double difference = 0;  ///< from the median of the others [rad or m]
};

struct MeanResult {
  std::vector<MeanObservation> observations;
  std::vector<InstrumentErrors> instrument;  ///< one per set-up
  std::vector<RemovedReading> removed;
  std::vector<std::string> warnings;  ///< which readings contradict each other, one sentence a line of the file
  std::vector<std::string>
      knocked;  ///< first of the warnings: set-ups of which many targets were read twice, and far apart
  std::vector<std::string> notes;  ///< collimation and index of each set-up
};

/// Readings with their own sigma, or in a covariance, stay as they are; all others of one set-up, kind, target and
/// target height become one mean. Sets whose circle was turned in between (constant offset of all directions) are
/// brought onto the first, and so is what was read after a turn within a set (circle_steps). Before that each reading
/// is tested (test_readings): one that the majority contradicts is left out, two that contradict each other become
/// observations of their own, so that the network decides between them. Readings in one face get the set-up's
/// collimation and index taken out where three pairs determine them.
MeanResult mean_observations(const SurveyObservations& survey);

}  // namespace plumbline::survey

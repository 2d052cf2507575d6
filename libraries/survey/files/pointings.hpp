// Observations put together again as the sightings they were measured in, for writers of one line or element a
// sighting.
#pragma once

#include <string>
#include <vector>

#include "survey/model/survey_observations.hpp"

namespace plumbline::survey {

/// Members are nullptr where nothing of that kind was measured; `first` is any of them and never nullptr.
struct Pointing {
  const Observation* first = nullptr;
  const Observation* direction = nullptr;
  const Observation* zenith_angle = nullptr;
  const Observation* slope_distance = nullptr;
  const Observation* horizontal_distance = nullptr;
  const Observation* height_difference = nullptr;
};

/// The sightings of all set-ups, in the order of the set-ups. They point into `survey`. Throws std::runtime_error, with
/// `writer` in front of the text, for observations without a set-up or value, of kinds that are no part of a sighting,
/// and for two values of a kind in one sighting.
std::vector<Pointing> pointings_of(const SurveyObservations& survey, const std::string& writer);

}  // namespace plumbline::survey

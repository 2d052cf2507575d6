// Part of find_causes.cpp: enough of a large job to try a hypothesis on.
#pragma once

#include <string>

#include "survey/model/survey_observations.hpp"

namespace plumbline::survey {

struct SurveySample {
  SurveyObservations survey;      ///< set-ups have the numbers they had; those left out have no readings
  int set_up = -1;                ///< the one it was made for
  std::size_t taken = 0, of = 0;  ///< set-ups with readings
  bool is_whole() const { return taken == of; }
  std::string in_words() const;  ///< " (tried on 12 of 90 set-ups)"; empty if it is whole
};

/// The set-up (-1: the one that shares most sights), and after it always the one that shares most points with those
/// taken before, until there are `most` readings or more, from three set-ups at least. All of a job that has fewer.
/// Readings without a set-up and covariances of readings are left out of a part.
SurveySample sample_of(const SurveyObservations& survey, int set_up, std::size_t most);

}  // namespace plumbline::survey

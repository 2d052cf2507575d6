// Each set-up beside all others, before anything is adjusted: mistakes so large, or of such a kind, that least squares
// would spread them over the network and blame innocent readings. Named are distances in another unit, names that are
// swapped or wrong, a circle that was turned and an instrument that was moved while measuring, and gross single
// readings.
#pragma once

#include <string>
#include <vector>

#include "survey/start/set_up_chain.hpp"

namespace plumbline::survey {

struct SetUpProblem {
  enum class Kind { unit, swapped_names, wrong_name, turned_circle, moved_instrument, reading } kind = Kind::reading;
  int set_up = 0;
  bool certain = true;              ///< false: it may as well be the mistake of another set-up; it is not mended
  double size = 0;                  ///< unit: by which distances are to be multiplied; turned circle: turn [rad]
  std::vector<std::string> points;  ///< concerned
  std::vector<int> observations;    ///< mean observations that are wrong
  std::vector<int> orders;          ///< first readings of the sights concerned
  std::string text;
};

std::vector<SetUpProblem> check_set_ups(const SurveyObservations& survey,
                                        const std::vector<MeanObservation>& observations, const SetUpChain& chain);

/// Mends in the survey what can be mended without losing a reading: a unit, a turned circle (the readings after it
/// become a set-up of their own), a moved instrument (a set-up and a station of their own). True if anything was.
/// Readings under a wrong name stay as they are; they are to be left out.
bool mend_set_ups(const std::vector<SetUpProblem>& problems, const std::vector<MeanObservation>& means,
                  SurveyObservations& survey);

}  // namespace plumbline::survey

// Whether readings that agree to the last digit are the same readings. Instruments show few digits: two sights of one
// target in coarse digits agree mostly by chance, in fine ones hardly ever.
#pragma once

#include <vector>

#include "survey/model/survey_observations.hpp"

namespace plumbline::survey {

/// Smallest steps that the values of a set of readings are written in: of angles [rad] and of lengths [m]; 0: none
/// is found.
struct Digits {
  double angle = 0, length = 0;
};

Digits digits_of(const std::vector<const Observation*>& readings);

bool is_angle_reading(const Observation& o);

/// Logarithm of the chance that a second sight gives the value within `window` of the first [rad or m], for an
/// instrument better than most: of another one the chance is smaller.
double log_chance(const Observation& o, double window);

/// Below this a set of readings is no coincidence (one in a million).
inline constexpr double kNoCoincidence = -13.8;

/// Logarithm of the number of ways in which `k` of `n` sights could have come out alike.
double log_choices(int n, int k);

}  // namespace plumbline::survey

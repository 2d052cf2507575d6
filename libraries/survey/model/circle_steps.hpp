// The circle turned while a face was being read: a slipped clamp, a knocked tripod, an orientation set anew.
#pragma once

#include <numbers>
#include <string>
#include <vector>

#include "survey/model/survey_observations.hpp"

namespace plumbline::survey {

inline constexpr double kMgon = std::numbers::pi / 200e3;  ///< [rad]

/// From observation `first` on, the directions of the set-up read `turn` [rad] more than before it.
struct CircleStep {
  int set_up = -1;
  int first = -1;  ///< index of the first direction after the turn
  double turn = 0;
  int with = 0, without = 0;  ///< pairs of readings to one target with the turn between them, and without
};

/// Turns that the readings of a set-up show among themselves. The two readings of a target in one set differ by twice
/// the collimation, plus the turn if that happened between them. A turn is told where at least three pairs show it,
/// three do not, nine of ten pairs follow, and it is ten times their scatter and 5 mgon at least. A turn at the change
/// of face has every pair across it: it looks like a collimation, and the means of the faces are free of it.
std::vector<CircleStep> circle_steps(const SurveyObservations& survey);

/// A sentence on one.
std::string in_words(const CircleStep& step, const SurveyObservations& survey);

}  // namespace plumbline::survey

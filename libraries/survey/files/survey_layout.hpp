// A planned survey as one table: markers with their place on the facade, set-ups, and what each set-up is to sight.
//
//   kind,id,east_m,north_m,height_m,floor,column,facing_azimuth_deg,sees
//   marker,F01-C01-R1,0,0,0.5,1,1,180,
//   set_up,S1,-1,-12,1.6,,,,F01-* F02-*
//
// Delimiter and decimal separator are detected. `floor` counts from 1 and is 1 where the column is missing; `column` 0
// or empty: none; `facing_azimuth`: clockwise from north, empty: unknown; `sees`: names with '*' and '?', separated by
// blanks; empty: all markers within the limits of the plan.
#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

#include "survey/model/survey_observations.hpp"

namespace plumbline::survey {

struct LayoutMarker {
  std::string id;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< E, N, H [m]
  int floor = 1, column = 0;
  double facing_azimuth = kNotGiven;  ///< [rad]
};

struct LayoutSetUp {
  std::string id;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< of the tilting axis [m]
  std::vector<std::string> sees;                       ///< names of markers; empty: all that can be seen
};

struct SiteLayout {
  std::vector<LayoutMarker> markers;
  std::vector<LayoutSetUp> set_ups;
};

/// Throws SurveyReadError with file, line and column: a plan with a hole in it is not a plan.
SiteLayout read_survey_layout(std::string_view bytes, const std::string& file);

/// `name` against a pattern of '*' (any text) and '?' (one character).
bool matches_pattern(std::string_view name, std::string_view pattern);

}  // namespace plumbline::survey

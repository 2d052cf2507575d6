// Part of merge_surveys.cpp: names that a second file gives to other marks.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "survey/model/survey_observations.hpp"

namespace plumbline::survey {

/// Where the set-ups of a file see its points, in one frame of its own; points it cannot place are not among them.
std::map<std::string, Eigen::Vector3d> seen_places(const SurveyObservations& survey);

/// Names that both have, where fewer than half of them lie at the same places after any levelled motion (in any unit of
/// length): numbering began again. Without those that do lie at the same places, if three or more do. Four shared names
/// at least; else nothing is said.
std::vector<std::string> reused_names(const std::map<std::string, Eigen::Vector3d>& a,
                                      const std::map<std::string, Eigen::Vector3d>& b);

}  // namespace plumbline::survey

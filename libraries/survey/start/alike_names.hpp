// Names that are one to a person and two to a program: P3 and p3, P03, P-3, PO3 with the letter O, MÜ1 and MUE1. What
// is meant as one mark falls apart in two points, and a known point holds nothing.
#pragma once

#include <string>
#include <vector>

#include "survey/model/adjust_options.hpp"
#include "survey/model/network_result.hpp"
#include "survey/model/survey_observations.hpp"

namespace plumbline::survey {

/// What spellings of one mark have in common: text::bare_name, with umlauts in either encoding, capital, small or
/// written out (MÜ1, mü1, MUE1), and with the letters O, I and l beside a digit taken for the digits they look like.
std::string folded_name(const std::string& name);

/// Known points that no reading touches, of those in `known` and those that the files hold or have keyed in: a warning
/// where one differs from a measured point, known by nobody, in case, separators, leading zeros, the spelling of
/// umlauts or letters that look like digits only; a note of the others in `known`.
std::vector<Finding> examine_known_names(const SurveyObservations& survey, const std::vector<std::string>& known);

/// Known points that no reading touches and that lie within 20 mm of a point that was read and that nobody knows: a
/// mistyped name, whose mark holds nothing. A warning of all.
std::vector<Finding> examine_unread_places(const NetworkResult& result, const ControlPoints& known);

/// Points of one adjusted network whose names are alike and that come out within 100 mm of each other [m, result's
/// frame]: a warning for each pair.
std::vector<Finding> examine_alike_points(const NetworkResult& result);

}  // namespace plumbline::survey

// The plain-text networks (.dat) of F. Krumm's collection of worked adjustment examples, University of Stuttgart:
// sections in brackets, '%' and '#' for comments.
#pragma once

#include <string>
#include <string_view>

#include "survey/model/survey_observations.hpp"

namespace plumbline::survey {

/// Reads [Coordinates], [Datum], [Sigma0], [SpatialDistances], [HorizontalDistances] (or [Distances]) and
/// [HeightDifferences]. Points named after `fix` in [Datum] are fixed axis by axis, after `dyn` or `free` constrained.
/// Standard deviations: a value behind the observation (sigma_c, in metres), with a second one sqrt(sigma_c^2 + s
/// sigma_s^2); without one that of [Sigma0], all of one weight. Axes x, y are taken as E, N. Other sections are listed
/// as skipped. Throws SurveyReadError when there is nothing of these.
SurveyObservations read_krumm(std::string_view bytes, const std::string& file);

}  // namespace plumbline::survey

// Carlson RW5 raw data: one record a line, fields with commas, each with a one- or two-letter head.
#pragma once

#include <string>
#include <string_view>

#include "survey/model/survey_observations.hpp"

namespace plumbline::survey {

/// Reads modes (MO: units), occupied points (OC), heights (LS), points (SP) and the sightings SS, TR, BD, BR, FD, FR;
/// the R of the last pairs is face 2. Horizontal readings may be angles right or left, deflections, azimuths or
/// bearings; vertical ones zenith or vertical angles or changes of elevation. A set-up begins at OC, and at BK when
/// sightings were made since. Throws SurveyReadError when there is nothing of these.
SurveyObservations read_rw5(std::string_view bytes, const std::string& file);

}  // namespace plumbline::survey

// Sokkia SDR33 and SDR2x: records of fixed columns, a four-character tag first.
#pragma once

#include <string>
#include <string_view>

#include "survey/model/survey_observations.hpp"

namespace plumbline::survey {

/// Reads stations (02), target heights (03), coordinates (08) and observations (09; F1 and F2 are the faces). Units,
/// coordinate order and the variant with 10-character fields come from the header 00NM, the zero of vertical angles
/// from the instrument record 01. Reduced observations (11) are left out, a scale factor (06) is not applied. Throws
/// SurveyReadError when there is nothing of these.
SurveyObservations read_sdr33(std::string_view bytes, const std::string& file);

}  // namespace plumbline::survey

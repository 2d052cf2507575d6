// Trimble JobXML (.jxl): the field book of a job as XML.
#pragma once

#include <string>
#include <string_view>

#include "survey/model/survey_observations.hpp"

namespace plumbline::survey {

/// Reads stations, targets and circle observations of the FieldBook, keyed-in points and the reduced coordinates.
/// Circle values are decimal degrees and metres whatever the job displays; distances are raw there and get ppm (of the
/// station's atmosphere) and prism constant (of the target), s (1 + ppm 1e-6) + c. Deleted records and mean turned
/// angles, which repeat single ones, are left out. Throws SurveyReadError when the file is no JobXML or has no field
/// book data.
SurveyObservations read_jobxml(std::string_view bytes, const std::string& file);

}  // namespace plumbline::survey

// Which survey format a file is in, from its content; the name only helps where the content leaves it open.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "survey/model/survey_observations.hpp"

namespace plumbline::survey {

enum class SurveyFormat {
  gsi,
  landxml,
  jobxml,
  sdr33,
  rw5,
  gama_xml,
  krumm,
  setup_coordinates,
  csv,
  zeiss,
  nikon,
  topcon_gts7,
  topcon_gts210,
  topcon_level,
  geodimeter,
  idx,
  starnet,
  dynaml
};

/// Short name, e.g. "gsi", and what a person calls it, e.g. "Leica GSI".
const char* short_name(SurveyFormat format);
const char* long_name(SurveyFormat format);

/// The format of `bytes`, nullopt if it looks like none. Reads the beginning only (16 KiB) and never throws.
std::optional<SurveyFormat> detect_survey_format(std::string_view bytes, const std::string& file_name);

/// Reads a file of any of the formats with the reader's default options; `angle_unit` of tables as in
/// SurveyCsvOptions. Throws SurveyReadError, for a file of no known format with what its first line is and what formats
/// are understood.
SurveyObservations read_survey(std::string_view bytes, const std::string& file, const std::string& angle_unit = "");

}  // namespace plumbline::survey

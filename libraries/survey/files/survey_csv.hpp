// Survey data in CSV files: tables of points, of sightings, of per-set-up coordinates, and our own table that holds all
// observations. Delimiter and decimal separator are detected; columns are known by their header or by a given order.
#pragma once

#include <string>
#include <string_view>

#include "survey/model/survey_observations.hpp"

namespace plumbline::survey {

struct SurveyCsvOptions {
  /// Order of the columns when the file has no header: letters (P point, E, N, Z or H height, D description, C code,
  /// '-' column to pass over; "PENZD", "PNEZD") or column names with commas ("station,target,hz,v,sd"). Empty: by the
  /// header; a table without one is taken as PENZD, with a warning.
  std::string columns = "";
  /// Of angle columns without a unit in their header: gon, deg, dms (D.MMSSs), rad. Empty: what the readings tell (both
  /// faces, reciprocal zenith angles), with a warning; where they do not, the table is refused.
  std::string angle_unit = "";
  /// Of length columns without a unit in their header: m, cm, mm, ft, usft. Empty: m, with a warning where a table of
  /// sightings names none for any length.
  std::string length_unit = "";
};

/// Reads a table of points (id, E, N, H, code; with sigma_e, sigma_n, sigma_h or cov_ee, cov_en, ... also as
/// coordinates with covariance, for control), a table of sightings (station, target, hz, v, sd, ih, th, face ...), or
/// the table that write_survey_csv writes. A unit stands in the header: "hz [gon]", "sigma_h [mm]", "sd_ft". Throws
/// SurveyReadError when there is no such table or an option or unit is unknown.
SurveyObservations read_survey_csv(std::string_view bytes, const std::string& file,
                                   const SurveyCsvOptions& options = {});

/// Reads points in the frame of each set-up, as camera-based sensors give them: columns set_up (or station), point, x,
/// y, z [m], and optionally sigma_x, sigma_y, sigma_z or the covariance cov_xx, cov_xy, cov_xz, cov_yy, cov_yz, cov_zz
/// [of lengths, squared], target_height, instrument_height. The frame is LocalCoordinate's: z up, y at the zero of the
/// circle, x to its right, origin in the instrument's centre. Throws SurveyReadError likewise.
SurveyObservations read_setup_coordinates(std::string_view bytes, const std::string& file,
                                          const SurveyCsvOptions& options = {});

/// Whether the header of a CSV file is that of per-set-up coordinates.
bool has_setup_coordinates_header(std::string_view bytes);

/// One row a point, set-up, observation or local coordinate, with a `record` column; angles in gon, lengths in m, all
/// digits, so that reading gives the same numbers to rounding. Throws std::runtime_error for what the table has no
/// place for: observation covariances, coordinate groups with more than one point, vectors.
std::string write_survey_csv(const SurveyObservations& survey);

}  // namespace plumbline::survey

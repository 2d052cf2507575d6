// Raw files of field books whose records are lines of comma-separated or labelled values: Nikon, Topcon, Geodimeter,
// Leica IDX. Each throws SurveyReadError when nothing in the file can be used.
#pragma once

#include <string>
#include <string_view>

#include "survey/model/survey_observations.hpp"

namespace plumbline::survey {

/// Nikon RAW V2.00, also as Ruide, Spectra Focus and Trimble M3 write it: records CO (units and order, in words), ST
/// (station, backsight, instrument height, azimuth, circle), F1, F2, SS (sightings), MP, MC, UP, CC, RE (coordinates).
/// Sightings of the backsight whose circle is not the station's yet are a set-up of their own. SO (staked out) and
/// records with a '*' in front are passed over, with a warning.
SurveyObservations read_nikon(std::string_view bytes, const std::string& file);

/// Topcon GTS-7 as TopSURV writes it, and South NTS: records STN, XYZ (E, N, H), BKB, BS, FS, SS and their HV, SD, HD.
SurveyObservations read_topcon_gts7(std::string_view bytes, const std::string& file);

/// Topcon GTS-210 and its kin: one stream of "_'station_(code_)height_+target_ ?+distance m zenith+circle d...".
/// Check sums at the ends of lines are taken off.
SurveyObservations read_topcon_gts210(std::string_view bytes, const std::string& file);

/// Topcon digital levels, and Sokkia's SDL. The text of the DL-100 series ("DL-100 TEXT": point, distance, staff,
/// height of the point ahead): back is the bench mark that the line begins on, then the point that was ahead before, in
/// the orders BF, BFFB, BBFF, FB, FBBF. The table of the SDL30 and its sisters DL-502 and DL-503: number, point, two
/// settings, 1 back or 2 ahead, distance, staff, height. A position whose readings do not give the height that stands
/// in the file is skipped, and said. Lengths in metres.
SurveyObservations read_topcon_level(std::string_view bytes, const std::string& file);
/// Whether a file of one of these levels begins with this line.
bool is_topcon_level(std::string_view line);

/// Geodimeter (JOB and ARE): a label and a value a line, "2=P100". Labels 2 station, 3 instrument height, 5 target, 6
/// signal height, 7, 24 and 17 horizontal circle (mean, face 1, face 2), 8, 25 and 18 vertical circle, 9 slope and 11
/// horizontal distance, 37, 38, 39 coordinates N, E, H, 23 units.
SurveyObservations read_geodimeter(std::string_view bytes, const std::string& file);

/// Leica IDX: points, set-ups and SLOPE tables, whose columns the file names.
SurveyObservations read_idx(std::string_view bytes, const std::string& file);

}  // namespace plumbline::survey

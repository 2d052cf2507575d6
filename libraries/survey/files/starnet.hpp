// STAR*NET data files (.dat): a letter for the kind of data, station names joined by '-', values, standard deviations.
#pragma once

#include <string>
#include <string_view>

#include "survey/model/survey_observations.hpp"

namespace plumbline::survey {

/// Reads C, E (coordinates, heights), A, D, V, DV, B, M, BM, SS (measurements), direction sets DB, DN, DM, DE,
/// traverses TB, T, TE, L (levelling, with its length), and the options .UNITS, .ORDER, .2D, .3D, .DELTA, .SEPARATOR.
/// Angles are D-M-S, or gon after .UNITS GONS, or degrees; without .ORDER coordinates are N, E and angles At-From-To,
/// which a warning says. Standard deviations stand behind the values, '!' holds, '*' frees, '&' is the default; HI/HT
/// are in metres or the file's unit. Measurements of one direction set, and of one traverse station, are one set-up.
/// What it does not know (GPS vectors, geodetic positions) is listed as skipped. Throws SurveyReadError when nothing
/// can be used.
SurveyObservations read_starnet(std::string_view bytes, const std::string& file);

/// Writes points (C, E; '!' fixed, a standard deviation for control, '*' else), one direction set (DB, DM, DN) a set-up
/// with what else was sighted behind it (DV, D, V), angles, azimuths and levelling; metres and D-M-S to 1e-5". Where
/// names contain '-', .SEPARATOR names another sign. Horizontal distances stand under .DELTA ON. Readings must be in
/// face
/// 1. Throws std::runtime_error for what the format has no place for: correlated values, vectors, coordinates in the
/// frame of a set-up, names with blanks.
std::string write_starnet(const SurveyObservations& survey);

}  // namespace plumbline::survey

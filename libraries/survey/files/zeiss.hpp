// Zeiss and Trimble M5, R5 and R4: lines of fields between '|', each value with its type and unit, of total stations
// (Elta, Trimble 3300, M3) and of digital levels (DiNi).
#pragma once

#include <string>
#include <string_view>

#include "survey/model/survey_observations.hpp"

namespace plumbline::survey {

/// Total stations: station (S) with coordinates, backsight (A), orientation Om, polar points with SD, Hz, V1, heights
/// th and ih, coordinates Y (east), X (north) or E, N, and Z. Levels: staff readings Rb, Rf, Rz (also Lr, Lv, Lz) with
/// distance HD (E) as height differences; the method of the line; what was repeated counts once.
/// Throws SurveyReadError when nothing can be used.
SurveyObservations read_zeiss(std::string_view bytes, const std::string& file);

}  // namespace plumbline::survey

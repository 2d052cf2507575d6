// LandXML 1.2 survey data and Leica's HeXML, which is the same with a second tree of Hexagon's own beside it.
// Coordinates are written north first.
#pragma once

#include <string>
#include <string_view>

#include "survey/model/survey_observations.hpp"

namespace plumbline::survey {

/// Reads points (CgPoint), set-ups (InstrumentSetup) and raw observations; `setupID` may stand at the observation, at
/// its group, or be the set-up it is inside of. Observations with status "deleted" are left out; directFace="false" or
/// a zenith angle above 180 degrees is face 2. Slope distances of HeXML get prism constant and ppm, (s - c)(1 + ppm
/// 1e-6) + c, unless the file says it was written by "LandXML Export", which applied them. Throws SurveyReadError when
/// the file is no LandXML or holds nothing of a survey.
SurveyObservations read_landxml(std::string_view bytes, const std::string& file);

/// LandXML 1.2 with units metre and gon: points with plane coordinates, set-ups and sightings, to the last digit of a
/// double; vectors, covariances and coordinate groups are not written. Throws std::runtime_error for what a
/// RawObservation cannot hold: observations without a set-up, angles, azimuths, height differences, an instrument
/// height of a single observation, two values of one kind in a sighting.
std::string write_landxml(const SurveyObservations& survey);

}  // namespace plumbline::survey

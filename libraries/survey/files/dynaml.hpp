// DynaML, the XML files of DynAdjust: stations, measurements, or both in one.
#pragma once

#include <string>
#include <string_view>

#include "survey/model/survey_observations.hpp"

namespace plumbline::survey {

/// Reads terrestrial measurements: slope (S) and chord (C) distances, zenith distances (V), vertical angles (Z),
/// horizontal angles (A), direction sets (D), level differences (L), heights (H). Every other one, such as a GNSS
/// baseline, stands in `skipped` by its name. Angles are D.MMSSs, their standard deviations seconds.
///
/// Stations in UTM, in latitude and longitude or geocentric (XYZ, which the frame of the file is taken to have on
/// GRS80) are put into a plane of their own, because UTM is shorter than the ground by up to 400 ppm: a transverse
/// Mercator projection about their mean with true lengths at their mean height. A warning says where it lies. More than
/// 20 km from its centre nothing is put into it: SurveyReadError. Throws that also when the file is no DynaML or holds
/// nothing that is read.
SurveyObservations read_dynaml(std::string_view bytes, const std::string& file);

}  // namespace plumbline::survey

// DynaML, the XML files of DynAdjust: stations, measurements, or both in one.
#pragma once

#include <string>
#include <string_view>

#include "survey/model/survey_observations.hpp"

namespace plumbline::survey {

/// Reads slope (S) and chord (C) distances, zenith distances (V), vertical angles (Z), horizontal angles (A), direction
/// sets (D), level differences (L), heights (H), GNSS baselines (G), clusters of them (X) and of points (Y). Every
/// other one stands in `skipped` by its name. Angles are D.MMSSs, their standard deviations seconds.
///
/// Stations in UTM, in latitude and longitude or geocentric (XYZ, which the frame of the file is taken to have on
/// GRS80) are put into a plane of their own, because UTM is shorter than the ground by up to 400 ppm: a transverse
/// Mercator projection about their mean with true lengths at their mean height, which is the map of the network
/// (NetworkInfo::coordinate_system). A warning says where it lies. Of a station more than 500 km from its centre, a
/// file that is no DynaML or one that holds nothing that is read: SurveyReadError.
SurveyObservations read_dynaml(std::string_view bytes, const std::string& file);

}  // namespace plumbline::survey

// What a projection's name says about the unit of its coordinates.
#pragma once

#include <string>

namespace plumbline::control {

/// In words, what coordinates of `projection` count in ("degrees", "US survey feet", …); empty for metres, and where
/// nothing tells. Known are EPSG codes ("EPSG:2263") and PROJ strings ("+proj=utm … +units=us-ft").
std::string other_unit_than_metres(const std::string& projection);

}  // namespace plumbline::control

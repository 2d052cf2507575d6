// Photographs that show a board from where another one does: a burst, or one file saved several times. To the
// statistics each is a photograph of its own, and the standard deviations shrink with nothing learned.
#pragma once

#include <string>
#include <vector>

#include "photo/markers/calibration.hpp"

namespace plumbline::markers {

/// How many there are, with an example; empty: none. Two are the same sight where the points that they share, nearly
/// all of the one with fewer, lie within half a pixel.
std::string repeated_sights(const std::vector<CalibrationView>& views);

}  // namespace plumbline::markers

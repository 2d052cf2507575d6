// A network result in the axes its file was written in, for whoever compares it with that file. Inside the project all
// is E, N, H.
#pragma once

#include <Eigen/Core>
#include <string>

#include "artifacts/survey_network.hpp"

namespace plumbline::survey {

/// Rows: x, y, z of the file from E, N, H; each row is one axis with its sign. `axes` is one of en, nw, se, ws, ne, sw,
/// es, wn ("sw": x south, y west), z is up; throws std::runtime_error for anything else.
Eigen::Matrix3d file_from_enh(const std::string& axes);

/// Brings positions, standard deviations, ellipsoids, and the rows of coordinates and vectors from E, N, H into `axes`
/// and names these. Directions and orientations stay clockwise.
void turn_to_file_axes(SurveyNetworkT& network, const std::string& axes);

}  // namespace plumbline::survey

// Edges of a quadrilateral as straight lines through the steepest grey values: good to a tenth of a pixel or two, also
// where blur is too large for the fit of edge_fit.hpp.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

#include "photo/detect/square_code.hpp"

namespace plumbline::detect {

/// Corners, clockwise as seen, of the edges moved to where the grey values change most, within `reach` px. Nothing if
/// an edge shows no change of the wanted direction.
std::optional<std::array<Eigen::Vector2d, 4>> on_edges(const PixelRows& image,
                                                       const std::array<Eigen::Vector2d, 4>& corners, double reach,
                                                       bool bright_inside);

}  // namespace plumbline::detect

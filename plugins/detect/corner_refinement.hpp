// Corners of a tag as intersections of its four fitted edges.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

#include "detect/edge_fit.hpp"

namespace plumbline::detect {

struct RefinedCorners {
  std::array<Eigen::Vector2d, 4> corners;  ///< [px], in the order of the initial ones
  std::array<Eigen::Matrix2d, 4>
      covariances;  ///< [px²]; neighbours share an edge and are correlated, which is left out
};

/// Measures the corners of a quadrilateral whose edges are `modules` cells long and have one cell of plain colour on
/// either side, from initial corners that are right to about 2 px. Nothing if one of the edges cannot be fitted.
std::optional<RefinedCorners> refine_corners(const GreyImage& image, const std::array<Eigen::Vector2d, 4>& initial,
                                             int modules, const EdgeFitOptions& options);

}  // namespace plumbline::detect

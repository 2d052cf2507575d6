// What happens to the corners of a quadrilateral whose edges are all drawn inwards (transfer curve, halo, JPEG).
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstddef>

namespace plumbline {

/// Movement of each corner for one pixel of inset [1]: as much from both edges that meet there. Zero at a corner where
/// the edges hardly form one.
inline std::array<Eigen::Vector2d, 4> moved_by_inset(const std::array<Eigen::Vector2d, 4>& corners) {
  std::array<Eigen::Vector2d, 4> moved;
  for (std::size_t k = 0; k < 4; ++k) {
    const Eigen::Vector2d to = (corners[(k + 1) % 4] - corners[k]).normalized(),
                          back = (corners[(k + 3) % 4] - corners[k]).normalized();
    const double sine = std::abs(to.x() * back.y() - to.y() * back.x());
    moved[k] = sine > 0.05 ? Eigen::Vector2d((to + back) / sine) : Eigen::Vector2d::Zero();
  }
  return moved;
}

}  // namespace plumbline

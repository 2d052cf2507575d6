// The points of one panel as its parts see them: on the face, and in the cells of coverage and flatness.
#pragma once

#include <algorithm>
#include <cstddef>

#include "surface/dense/panel_surface.hpp"

namespace plumbline::surface {

struct Sample {
  double u, v, h, sigma;  ///< right, up and out of the design's face, from its middle [m]; of the random error [m]
  size_t tile;
  Eigen::Vector3d arm;  ///< from the tile's centre [m]
};

/// The six base functions of PanelSurface, with x and y from −1 to 1.
inline Vector6 base_at(double x, double y) {
  Vector6 base;
  base << 1, x, y, 1 - x * x, 1 - y * y, x * y;
  return base;
}

inline Vector6 base_of(const PanelFace& face, const Sample& s) {
  return base_at(2 * s.u / face.width, 2 * s.v / face.height);
}

/// How the face is divided into cells.
struct Division {
  double across, up;
  int columns, rows;
  Division(const PanelFace& face, const PanelOptions& options)
      : across(face.width - 2 * options.border),
        up(face.height - 2 * options.border),
        columns(std::max(1, static_cast<int>(across / options.cell))),
        rows(std::max(1, static_cast<int>(up / options.cell))) {}
  size_t cell_of(const Sample& s) const {
    const int c = std::clamp(static_cast<int>((s.u / across + 0.5) * columns), 0, columns - 1);
    const int r = std::clamp(static_cast<int>((s.v / up + 0.5) * rows), 0, rows - 1);
    return static_cast<size_t>(r) * columns + c;
  }
};

}  // namespace plumbline::surface

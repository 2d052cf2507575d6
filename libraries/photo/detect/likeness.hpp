// Whether the square that was read as a tag looks like the drawing of that tag. A dictionary of few cells or many codes
// reads a good share of all dark squares in a scene as one of its codes; what tells a marker from them is its border,
// the quiet zone around it, and cells of one colour each.
#pragma once

#include <Eigen/Core>
#include <array>

#include "photo/detect/square_code.hpp"

namespace plumbline::detect {

/// How far grey values follow a drawing.
struct Likeness {
  double correlation = -1;  ///< of the grey values with the drawing, over the square and 0.6 cells around it
  double worst_cell = 1e9;  ///< largest mean square deviation in one cell [square of the contrast]
};

/// `corners` of the upright drawing of code number `index`: bottom left, bottom right, top right, top left [px]. Light
/// that changes linearly over the square is allowed for, and a blur of 0.85 px.
Likeness likeness(const PixelRows& image, const std::array<Eigen::Vector2d, 4>& corners, const SquareFamily& family,
                  std::size_t index);

/// What a tag must at least look like, by chance_of_code(). Measured (docs/photographs.md): tags whose edges were
/// fitted have a correlation above 0.90 and no cell worse than 0.16; squares of scenes are below 0.85, and markers of
/// another dictionary have a cell worse than 0.24.
struct LikenessLimit {
  double correlation = -1;
  double worst_cell = 1e300;
  bool holds(const Likeness& l) const { return l.correlation >= correlation && l.worst_cell <= worst_cell; }
  bool checks() const { return correlation > -1; }
};
LikenessLimit likeness_limit(double chance);

constexpr double kWeakChance = 0.01;  ///< from here on a dictionary is called weak

}  // namespace plumbline::detect

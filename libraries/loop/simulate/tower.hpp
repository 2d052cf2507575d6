// A regular facade of any size: what tests, the benchmark and the simulated site plan on.
#pragma once

#include <cstdint>

#include "loop/fit/facade.hpp"

namespace plumbline::loop {

/// Panels between columns of brackets, one a bay and floor. Two rows of brackets on each floor; the ones between two
/// bays carry both neighbours. The left bracket of the upper row is the panel's fixed hook, the right one lets it slide
/// sideways, those of the lower row hold it only against the wind.
struct TowerOptions {
  int floors = 3, bays = 3;
  double width = 2.0, height = 4.0;  ///< of a bay and of a storey [m]
  double joint = 0.020;              ///< between panels [m]
  double joint_tolerance = 0.008;    ///< change of a joint's width, and step across it [m]
  double tolerance = 0.005;          ///< of corners, each direction [m]
  bool steps_judged = true;
  int facades = 1;  ///< 2: the same again round the corner to the right, names with E before them
};

/// Nothing measured yet: deviations are nan, the covariance is zero. Frame: x to the right, y into the building, z up.
Facade make_tower(const TowerOptions& options);

/// Index of a bracket of make_tower(): floors and rows from 0 at the bottom, columns 0 ... bays.
std::size_t tower_bracket(const TowerOptions& options, int floor, int row, int column);

}  // namespace plumbline::loop

// The grid of a design: axes by which people on site say where something is.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <string>
#include <vector>

#include "building/ifc/ifc_placement.hpp"

namespace plumbline {
struct DesignT;
}

namespace plumbline::ifc {

/// A straight axis, frame of the project.
struct GridAxis {
  std::string tag;            ///< "A", "4"
  std::string family;         ///< "u", "v" or "w": the list of its grid that it stands in
  Eigen::Vector3d point;      ///< on it [m]
  Eigen::Vector3d direction;  ///< unit vector
  double begin = -std::numeric_limits<double>::infinity(),
         end = std::numeric_limits<double>::infinity();  ///< from `point` along `direction` [m]
};

/// All straight axes of all grids; those that lie on one another under one tag (a grid for each storey) once. Axes
/// without tag and bent ones are left out, and counted in a warning.
std::vector<GridAxis> read_grid(const Model& model, Placements& placements, double length_unit,
                                std::vector<std::string>& warnings);
std::vector<GridAxis> grid_of(const DesignT& design);

/// Horizontal distance of a point from an axis as it is drawn, with 5 m at either end: axes of one wing are not those
/// of another one behind it [m].
double distance_to(const GridAxis& axis, const Eigen::Vector3d& point);

/// The axis that crosses a facade nearest to a point of it; `out` is the facade's direction. Null without one within
/// 20° of it.
const GridAxis* axis_across(const std::vector<GridAxis>& grid, const Eigen::Vector3d& point,
                            const Eigen::Vector3d& out);

/// "A/4": the nearest axis of each of the first two families; empty unless both have one.
std::string grid_place(const std::vector<GridAxis>& grid, const Eigen::Vector3d& point);

}  // namespace plumbline::ifc

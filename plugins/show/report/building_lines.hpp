// The building around its anchors, as lines for the view in space.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <utility>
#include <vector>

#include "artifacts/design.hpp"
#include "building/ifc/grid.hpp"

namespace plumbline::report {

/// What the view in space shows beside anchors and panels; frame of the design [m].
struct BuildingLines {
  std::vector<std::pair<Eigen::Vector3d, Eigen::Vector3d>> edges;  ///< of the boxes of slabs, walls, columns, ...
  double true_north = std::numeric_limits<double>::quiet_NaN();    ///< azimuth of north, clockwise from y [rad]
};

/// Edges of the boxes of the largest `most` elements whose shape is known and that are neither anchors nor panels, nor
/// what an earlier campaign added.
BuildingLines building_lines(const DesignT& design, std::size_t most = 150);

/// Axes of the grid as lines a little beyond the anchors, at the height of the lowest of them.
std::vector<std::pair<Eigen::Vector3d, Eigen::Vector3d>> grid_lines(const std::vector<ifc::GridAxis>& grid,
                                                                    const Eigen::Vector3d& low,
                                                                    const Eigen::Vector3d& high);

}  // namespace plumbline::report

// How wide the side of a panel is that the design shows outwards, beside its body.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>

#include "artifacts/design.hpp"

namespace plumbline::judgement {

/// Least and largest coordinates of a side of a panel along its own axes [m]: the box's, but of what is narrower there
/// (a sheet before a wider core, chamfered edges) the side's. `through`: the axis that the side looks along, 0 to 2;
/// `side`: positive, towards its larger coordinates.
inline Eigen::AlignedBox3d outer_side(const DesignElementT& element, int through, int side) {
  Eigen::AlignedBox3d box(Eigen::Vector3d(element.box_low), Eigen::Vector3d(element.box_high));
  if (element.rectangles.size() != 24) return box;
  const double* rectangle = element.rectangles.data() + 4 * (2 * through + (side > 0 ? 1 : 0));
  if (!std::isfinite(rectangle[0])) return box;
  for (const int k : {0, 1})
    box.min()[(through + 1 + k) % 3] = rectangle[k], box.max()[(through + 1 + k) % 3] = rectangle[2 + k];
  return box;
}

/// That of the side which looks most along `out`, a unit vector in the design's frame.
inline Eigen::AlignedBox3d outer_side(const DesignElementT& element, const Eigen::Vector3d& out) {
  const Eigen::Vector3d own = element.placement.rotation.conjugate() * out;
  Eigen::Index through = 0;
  own.cwiseAbs().maxCoeff(&through);
  return outer_side(element, static_cast<int>(through), own[through] > 0 ? 1 : -1);
}

}  // namespace plumbline::judgement

// What stands between a photograph and a face: other faces of the same building.
#pragma once

#include <vector>

#include "surface/dense/panel_surface.hpp"

namespace plumbline::surface {

/// The faces that may hide a part of a face from one place.
class Screens {
 public:
  /// Of `faces`, those that may hide a part of number `of`, `beyond` [m] around it, from `centre` in the world.
  Screens(const std::vector<PanelFace>& faces, size_t of, const Eigen::Vector3d& centre, double beyond);
  bool empty() const { return faces_.empty(); }
  /// Whether one of them lies on the way to `place` in the world, more than `kApart` before it.
  bool hide(const Eigen::Vector3d& place) const;
  /// Neighbours in one plane stand out by millimetres, and their faces are the design's: that hides nothing [m].
  static constexpr double kApart = 0.02;

 private:
  std::vector<const PanelFace*> faces_;
  Eigen::Vector3d centre_;
};

}  // namespace plumbline::surface

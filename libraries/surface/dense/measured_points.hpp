// Points of a surface with what is known of their errors: a random part of each point, and a systematic part that all
// points have in common, as a factor of low rank.
//
// The systematic displacement of a point p of a tile is t + ω × (p − centre), where (t, ω) = factor · z and z are
// independent standard normal numbers that are the same for all tiles of a cloud. So what is common to two planes
// cancels in their difference, and no number of points makes a plane's place better than the orientation of the
// photographs, or the registration of the scan, is.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace plumbline::surface {

struct MeasuredPoint {
  Eigen::Vector3f offset;  ///< from the tile's centre [m]
  float sigma = 0;         ///< of the random error along the surface's normal [m]
};

struct MeasuredTile {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< in the world [m]
  std::vector<MeasuredPoint> points;
  Eigen::Matrix<double, 6, Eigen::Dynamic> factor;  ///< (t [m], ω [rad]) by z; no columns: no systematic error is known
  Eigen::Vector3d at(const MeasuredPoint& point) const { return centre + point.offset.cast<double>(); }
};

}  // namespace plumbline::surface

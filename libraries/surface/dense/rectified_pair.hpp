// Two photographs turned so that a place of one lies in the same row of the other, and parallel to the facade as far as
// their baseline lets them: along a plane facade the disparity then hardly changes. Source: Fusiello, Trucco, Verri
// (2000), A compact algorithm for rectification of stereo pairs.
#pragma once

#include <optional>

#include "surface/dense/view.hpp"

namespace plumbline::surface {

/// Rectified coordinates have their origin at the principal point and are the same in both photographs but for the
/// disparity: x in the left one less x in the right one [px].
struct RectifiedPair {
  size_t left = 0, right = 0;       ///< numbers of the views
  Eigen::Matrix3d rect_from_world;  ///< x along the baseline, z towards the facade
  Eigen::Vector3d centre;           ///< of the left view [m]
  double baseline = 0;              ///< [m]
  double focal = 0;                 ///< [px]
  double depth = 0;                 ///< of the place it was made for [m]

  /// (x, y, disparity) of a point.
  Eigen::Vector3d rectified(const Eigen::Vector3d& world) const;
  /// The point of it; disparity above 0.
  Eigen::Vector3d world(const Eigen::Vector3d& rectified) const;
  /// Where a rectified pixel lies in the photograph; nothing where the camera model does not hold. `offset`: 0 for the
  /// left view, the baseline does not move rays.
  std::optional<Eigen::Vector2d> source(const View& view, const Eigen::Vector2d& rectified) const;
};

/// The pair of two views of a place of a facade [m]; pixels as large on the facade as the coarser photograph's. Nothing
/// where the place does not show in both, or the rays meet at less than 3° or more than 50°, or the baseline points at
/// the facade.
std::optional<RectifiedPair> rectified_pair(const FacadePlane& plane, const Eigen::Vector2d& place,
                                            const std::vector<View>& views, size_t one, size_t other);

/// Pairs of `views` for a place: those near 15° first, no view in more than `each` of them, at most `most`.
std::vector<RectifiedPair> pairs_for(const FacadePlane& plane, const Eigen::Vector2d& place,
                                     const std::vector<View>& views, int each, size_t most);

}  // namespace plumbline::surface

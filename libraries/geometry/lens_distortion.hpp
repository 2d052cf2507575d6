// The distortion of a lens with its derivatives, written once for one direction (T is double) or several side by side
// (V4).
#pragma once

#include "geometry/camera.hpp"
#include "geometry/vectors.hpp"

namespace plumbline {

/// Distorted normalised coordinates of (x, y), and their derivatives by them: d x' / d y equals d y' / d x.
template <typename T>
struct Distorted {
  T x, y;
  T by_xx, by_xy, by_yy;
};

/// What the fisheye's model makes of a direction at r = √(x² + y²): (x, y) is drawn at scale · (x, y).
template <typename T>
struct FisheyeScale {
  T scale;
  T slope;  ///< d scale / d r over r
  T ratio;  ///< θ / r
  T angle_squared;
};

/// `k`: k1 to k4; `r2`: r².
template <typename T>
PLUMBLINE_INLINE FisheyeScale<T> fisheye_scale(const double* k, const T& r2) {
  const T zero = 0 * r2, one = 1 + zero;
  const auto central = r2 < 1e-16;  // the limits on the axis: θ / r = 1 − r² / 3
  const T safe = central ? one : r2, r = root(safe), angle = arc_tangent(r);
  const T a2 = central ? zero : angle * angle, ratio = central ? one : angle / r;
  const T drawn = 1 + a2 * (k[0] + a2 * (k[1] + a2 * (k[2] + a2 * k[3])));  // over the angle
  const T by_angle = 1 + a2 * (3 * k[0] + a2 * (5 * k[1] + a2 * (7 * k[2] + a2 * (9 * k[3]))));
  const T scale = ratio * drawn, slope = (by_angle / (1 + r2) - scale) / safe;
  return {scale, central ? zero + 2 * (k[0] - 1.0 / 3) : slope, ratio, a2};
}

template <typename T>
PLUMBLINE_INLINE void distort(const InteriorOrientation& c, const T& x, const T& y, Distorted<T>& to) {
  const T r2 = x * x + y * y;
  if (c.lens == LensModel::fisheye) {
    const double k[4] = {c.k1, c.k2, c.k3, c.k4};
    const FisheyeScale<T> s = fisheye_scale(k, r2);
    to = {s.scale * x, s.scale * y, s.scale + s.slope * x * x, s.slope * x * y, s.scale + s.slope * y * y};
    return;
  }
  const T radial = 1 + r2 * (c.k1 + r2 * (c.k2 + r2 * c.k3));
  const T slope = 2 * (c.k1 + r2 * (2 * c.k2 + 3 * r2 * c.k3));  // d radial / d x = slope · x
  to.x = x * radial + 2 * c.p1 * x * y + c.p2 * (r2 + 2 * x * x);
  to.y = y * radial + c.p1 * (r2 + 2 * y * y) + 2 * c.p2 * x * y;
  to.by_xx = radial + slope * x * x + 2 * c.p1 * y + 6 * c.p2 * x;
  to.by_xy = slope * x * y + 2 * c.p1 * x + 2 * c.p2 * y;
  to.by_yy = radial + slope * y * y + 6 * c.p1 * y + 2 * c.p2 * x;
}

}  // namespace plumbline

// Brown's distortion with its derivatives, written once for one direction (T is double) or several side by side (V4).
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

template <typename T>
PLUMBLINE_INLINE void distort(const BrownCamera& c, const T& x, const T& y, Distorted<T>& to) {
  const T r2 = x * x + y * y;
  const T radial = 1 + r2 * (c.k1 + r2 * (c.k2 + r2 * c.k3));
  const T slope = 2 * (c.k1 + r2 * (2 * c.k2 + 3 * r2 * c.k3));  // d radial / d x = slope · x
  to.x = x * radial + 2 * c.p1 * x * y + c.p2 * (r2 + 2 * x * x);
  to.y = y * radial + c.p1 * (r2 + 2 * y * y) + 2 * c.p2 * x * y;
  to.by_xx = radial + slope * x * x + 2 * c.p1 * y + 6 * c.p2 * x;
  to.by_xy = slope * x * y + 2 * c.p1 * x + 2 * c.p2 * y;
  to.by_yy = radial + slope * y * y + 6 * c.p1 * y + 2 * c.p2 * x;
}

}  // namespace plumbline

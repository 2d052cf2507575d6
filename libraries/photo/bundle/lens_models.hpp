// The lens models written once, for one direction (T is double) or for the four corners of a tag side by side
// (V4). Formulas: lens.hpp.
#pragma once

#include "geometry/lens_distortion.hpp"
#include "photo/bundle/lens.hpp"

namespace plumbline::bundle {

template <typename T>
struct LensInput {
  const double* values;  ///< of the model
  double balance_radius = 0, inverse_reference = 0;
  T v[3];         ///< in the camera frame
  T observed[2];  ///< image coordinates
};

/// Column by column: two rows, then three and `max_interior` columns of two.
template <typename T>
struct LensOutput {
  T* misclosure;
  T* by_direction;
  T* by_interior;

  PLUMBLINE_INLINE void set_interior(int column, const T& x, const T& y) const {
    by_interior[2 * column] = x;
    by_interior[2 * column + 1] = y;
  }
  /// From the columns of v_x and v_y on: what scales the whole vector moves nothing, but for `x`, `y` by the depth.
  PLUMBLINE_INLINE void set_direction(const T& xx, const T& xy, const T& yx, const T& yy, const T& u, const T& w,
                                      const T& x, const T& y) const {
    by_direction[0] = xx;
    by_direction[1] = yx;
    by_direction[2] = xy;
    by_direction[3] = yy;
    by_direction[4] = x - (xx * u + xy * w);
    by_direction[5] = y - (yx * u + yy * w);
  }
  PLUMBLINE_INLINE void set_distance_terms(int k1, const T& s, int d1) const {
    for (int k = 0; k < 4; ++k) by_interior[2 * d1 + k] = s * by_interior[2 * k1 + k];
  }
};

template <typename T>
PLUMBLINE_INLINE void brown(const LensInput<T>& at, bool jacobians, const LensOutput<T>& to) {
  const double* p = at.values;
  const T iz = 1 / at.v[2], x = at.v[0] * iz, y = at.v[1] * iz;
  const T xx = x * x, yy = y * y, xy = x * y, r2 = xx + yy;
  const T s = iz - at.inverse_reference;
  const T k1 = p[4] + p[9] * s, k2 = p[5] + p[10] * s;
  const double k3 = p[6], p1 = p[7], p2 = p[8];
  const T radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
  const T xd = x * radial + 2 * p1 * xy + p2 * (r2 + 2 * xx);
  const T yd = y * radial + p1 * (r2 + 2 * yy) + 2 * p2 * xy;
  to.misclosure[0] = p[0] * xd + p[2] - at.observed[0];
  to.misclosure[1] = p[1] * yd + p[3] - at.observed[1];
  if (!jacobians) return;
  const T slope = 2 * (k1 + r2 * (2 * k2 + 3 * r2 * k3));
  const T mixed = slope * xy + 2 * p1 * x + 2 * p2 * y;
  const T fx = p[0] * x, fy = p[1] * y, r4 = r2 * r2, r6 = r4 * r2;
  const T by_depth = -iz * iz * (p[9] * r2 + p[10] * r4);
  to.set_direction(p[0] * (radial + slope * xx + 2 * p1 * y + 6 * p2 * x) * iz, p[0] * mixed * iz, p[1] * mixed * iz,
                   p[1] * (radial + slope * yy + 6 * p1 * y + 2 * p2 * x) * iz, x, y, by_depth * fx, by_depth * fy);
  const T zero = 0 * xd, one = 1 + zero;
  to.set_interior(0, xd, zero);
  to.set_interior(1, zero, yd);
  to.set_interior(2, one, zero);
  to.set_interior(3, zero, one);
  to.set_interior(4, fx * r2, fy * r2);
  to.set_interior(5, fx * r4, fy * r4);
  to.set_interior(6, fx * r6, fy * r6);
  to.set_interior(7, p[0] * 2 * xy, p[1] * (r2 + 2 * yy));
  to.set_interior(8, p[0] * (r2 + 2 * xx), p[1] * 2 * xy);
  to.set_distance_terms(4, s, 9);
}

template <typename T>
PLUMBLINE_INLINE void balanced(const LensInput<T>& at, bool jacobians, const LensOutput<T>& to) {
  const double* p = at.values;
  const T iz = 1 / at.v[2], u = at.v[0] * iz, w = at.v[1] * iz, x = p[0] * u, y = p[0] * w;
  const T xx = x * x, yy = y * y, xy = x * y, r2 = xx + yy, r4 = r2 * r2, r6 = r4 * r2;
  const double b2 = at.balance_radius * at.balance_radius, b4 = b2 * b2, b6 = b4 * b2;
  const T s = -iz - at.inverse_reference, a1 = p[3] + p[10] * s, a2 = p[4] + p[11] * s;
  const T dr = a1 * (r2 - b2) + a2 * (r4 - b4) + p[5] * (r6 - b6);
  to.misclosure[0] = p[1] + x + x * dr + p[6] * (r2 + 2 * xx) + 2 * p[7] * xy + p[8] * x + p[9] * y - at.observed[0];
  to.misclosure[1] = p[2] + y + y * dr + p[7] * (r2 + 2 * yy) + 2 * p[6] * xy - at.observed[1];
  if (!jacobians) return;
  const T slope = 2 * (a1 + r2 * (2 * a2 + 3 * r2 * p[5]));  // d dr / dx = slope x
  const T dxx = 1 + dr + slope * xx + 6 * p[6] * x + 2 * p[7] * y + p[8];
  const T dxy = slope * xy + 2 * p[6] * y + 2 * p[7] * x + p[9];
  const T dyx = slope * xy + 2 * p[7] * x + 2 * p[6] * y;
  const T dyy = 1 + dr + slope * yy + 6 * p[7] * y + 2 * p[6] * x;
  const T c = p[0] * iz, by_depth = iz * iz * (p[10] * (r2 - b2) + p[11] * (r4 - b4));
  to.set_direction(dxx * c, dxy * c, dyx * c, dyy * c, u, w, by_depth * x, by_depth * y);
  const T zero = 0 * x, one = 1 + zero;
  to.set_interior(0, dxx * u + dxy * w, dyx * u + dyy * w);
  to.set_interior(1, one, zero);
  to.set_interior(2, zero, one);
  to.set_interior(3, x * (r2 - b2), y * (r2 - b2));
  to.set_interior(4, x * (r4 - b4), y * (r4 - b4));
  to.set_interior(5, x * (r6 - b6), y * (r6 - b6));
  to.set_interior(6, r2 + 2 * xx, 2 * xy);
  to.set_interior(7, 2 * xy, r2 + 2 * yy);
  to.set_interior(8, x, zero);
  to.set_interior(9, y, zero);
  to.set_distance_terms(3, s, 10);
}

template <typename T>
PLUMBLINE_INLINE void correcting(const LensInput<T>& at, bool jacobians, const LensOutput<T>& to) {
  const double* p = at.values;
  const T iz = 1 / at.v[2], u = at.v[0] * iz, w = at.v[1] * iz;
  const T mx = at.observed[0] - p[1], my = p[2] - at.observed[1];
  const T x = (1 + p[8]) * mx + p[9] * my, y = my;
  const T xx = x * x, yy = y * y, xy = x * y, r2 = xx + yy, r4 = r2 * r2, r6 = r4 * r2;
  const T s = -iz - at.inverse_reference, k1 = p[3] + p[10] * s, k2 = p[4] + p[11] * s;
  const T radial = 1 + k1 * r2 + k2 * r4 + p[5] * r6;
  to.misclosure[0] = -p[0] * u - (x * radial + p[6] * (r2 + 2 * xx) + 2 * p[7] * xy);
  to.misclosure[1] = -p[0] * w - (y * radial + p[7] * (r2 + 2 * yy) + 2 * p[6] * xy);
  if (!jacobians) return;
  const T zero = 0 * u, c = -p[0] * iz, by_depth = iz * iz * (p[10] * r2 + p[11] * r4);
  to.set_direction(c, zero, zero, c, u, w, -by_depth * x, -by_depth * y);
  const T slope = 2 * (k1 + r2 * (2 * k2 + 3 * r2 * p[5]));
  // Of the corrected coordinates by (x, y).
  const T dxx = radial + slope * xx + 6 * p[6] * x + 2 * p[7] * y, dxy = slope * xy + 2 * p[6] * y + 2 * p[7] * x;
  const T dyx = slope * xy + 2 * p[7] * x + 2 * p[6] * y, dyy = radial + slope * yy + 6 * p[7] * y + 2 * p[6] * x;
  to.set_interior(0, -u, -w);
  to.set_interior(1, dxx * (1 + p[8]), dyx * (1 + p[8]));
  to.set_interior(2, -(dxx * p[9] + dxy), -(dyx * p[9] + dyy));
  to.set_interior(3, -x * r2, -y * r2);
  to.set_interior(4, -x * r4, -y * r4);
  to.set_interior(5, -x * r6, -y * r6);
  to.set_interior(6, -(r2 + 2 * xx), -2 * xy);
  to.set_interior(7, -2 * xy, -(r2 + 2 * yy));
  to.set_interior(8, -dxx * mx, -dyx * mx);
  to.set_interior(9, -dxx * my, -dyx * my);
  to.set_distance_terms(3, s, 10);
}

template <typename T>
PLUMBLINE_INLINE void fisheye(const LensInput<T>& at, bool jacobians, const LensOutput<T>& to) {
  const double* p = at.values;
  const T iz = 1 / at.v[2], x = at.v[0] * iz, y = at.v[1] * iz;
  const FisheyeScale<T> s = fisheye_scale(p + 4, x * x + y * y);
  to.misclosure[0] = p[0] * s.scale * x + p[2] - at.observed[0];
  to.misclosure[1] = p[1] * s.scale * y + p[3] - at.observed[1];
  if (!jacobians) return;
  const T zero = 0 * x, one = 1 + zero;
  to.set_direction(p[0] * (s.scale + s.slope * x * x) * iz, p[0] * s.slope * x * y * iz, p[1] * s.slope * x * y * iz,
                   p[1] * (s.scale + s.slope * y * y) * iz, x, y, zero, zero);
  to.set_interior(0, s.scale * x, zero);
  to.set_interior(1, zero, s.scale * y);
  to.set_interior(2, one, zero);
  to.set_interior(3, zero, one);
  T power = s.ratio;
  for (int k = 4; k < 8; ++k) {
    power *= s.angle_squared;
    to.set_interior(k, p[0] * power * x, p[1] * power * y);
  }
}

template <typename T>
PLUMBLINE_INLINE void compute_lens(Lens lens, const LensInput<T>& at, bool jacobians, const LensOutput<T>& to) {
  if (lens == Lens::brown)
    brown(at, jacobians, to);
  else if (lens == Lens::balanced)
    balanced(at, jacobians, to);
  else if (lens == Lens::fisheye)
    fisheye(at, jacobians, to);
  else
    correcting(at, jacobians, to);
}

constexpr double nearest = 1e-9;  ///< of |v_z| against |v|: a ray in the plane of the projection centre has no image

}  // namespace plumbline::bundle

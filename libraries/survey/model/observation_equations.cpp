#include "survey/model/observation_equations.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

namespace plumbline::survey {

double wrap_angle(double angle) {
  const double wrapped = std::remainder(angle, 2 * std::numbers::pi);  // [-pi, pi]
  return wrapped == -std::numbers::pi ? std::numbers::pi : wrapped;
}

namespace {

using Eigen::Map;
using Eigen::Vector3d;

/// The line of sight as the instrument sees it, with what is needed to bring partials back to the parameters.
struct SightLine {
  Vector3d d;      // in the instrument's frame (tilted by t if there is a tilt block)
  Vector3d level;  // before the tilt
  Vector3d tilt = Vector3d::Zero();
};

SightLine sight(const Equation& eq, int target, double target_height, double rise, const double* const* values) {
  SightLine s;
  s.level = Map<const Vector3d>(values[target]) - Map<const Vector3d>(values[eq.from]);
  s.level.z() += target_height - eq.instrument_height + rise;
  s.level.head<2>() /= eq.map_scale;
  if (eq.centring >= 0) s.level.head<2>() -= Map<const Eigen::Vector2d>(values[eq.centring]);
  if (eq.instrument_height_correction >= 0) s.level.z() -= values[eq.instrument_height_correction][0];
  if (eq.tilt >= 0) s.tilt = {values[eq.tilt][0], values[eq.tilt][1], 0};
  s.d = s.level - s.tilt.cross(s.level);  // the axes turn by t, what they see turns back
  return s;
}

/// Where the partials of one row go; null pointers are skipped.
struct RowWriter {
  double* const* jacobians;
  int row;
  void add(int slot, int size, int component, double value) const {
    if (slot >= 0 && jacobians[slot]) jacobians[slot][row * size + component] += value;
  }
};

/// Spreads the partial by the sight onto points, tilt and instrument height.
void add_sight_partials(const Equation& eq, int target, const SightLine& s, const Vector3d& by_d,
                        const RowWriter& out) {
  // d = (I + [t]x) level, so the partial by `level` is (I + [t]x)' by_d = by_d - t x by_d.
  const Vector3d by_level = by_d + s.tilt.cross(by_d);
  for (int k = 0; k < 3; ++k) {
    const double by_point = k < 2 ? by_level[k] / eq.map_scale : by_level[k];
    out.add(target, 3, k, by_point);
    out.add(eq.from, 3, k, -by_point);
  }
  for (int k = 0; k < 2; ++k) out.add(eq.centring, 2, k, -by_level[k]);
  out.add(eq.instrument_height_correction, 1, 0, -by_level.z());
  const Vector3d by_tilt = by_d.cross(s.level);  // -by_d . (t x level) = t . (by_d x level)
  out.add(eq.tilt, 2, 0, by_tilt.x());
  out.add(eq.tilt, 2, 1, by_tilt.y());
}

/// Azimuth of the sight and its gradient.
bool azimuth(const Vector3d& d, double& value, Vector3d& gradient) {
  const double h2 = d.x() * d.x() + d.y() * d.y();
  if (h2 < 1e-12) return false;
  value = std::atan2(d.x(), d.y());
  gradient = {d.y() / h2, -d.x() / h2, 0};
  return true;
}

bool zenith_angle(const Equation& eq, const SightLine& s, const double* const* values, double& value,
                  Vector3d& gradient, double& by_refraction) {
  const double h = std::hypot(s.d.x(), s.d.y());
  if (h < 1e-6) return false;
  double bend = 0;  // (1 - k) / R
  if (eq.curvature)
    bend = (1 - (eq.refraction >= 0 ? values[eq.refraction][0] : eq.refraction_coefficient)) / kEarthRadius;
  const double q = s.d.z() - 0.5 * bend * h * h;
  const double s2 = h * h + q * q;
  value = std::atan2(h, q);
  const double by_h = q / s2 + h / s2 * bend * h;  // q itself depends on h
  gradient = {by_h * s.d.x() / h, by_h * s.d.y() / h, -h / s2};
  by_refraction = -h / s2 * 0.5 * h * h / kEarthRadius;
  return true;
}

bool distance(const Equation& eq, const Vector3d& d, const double* const* values, double& value, Vector3d& gradient,
              double& length) {
  Vector3d reduced = d;
  if (eq.kind == ObservationKind::horizontal_distance) reduced.z() = 0;
  length = reduced.norm();
  if (length < 1e-9) return false;
  const double scale = eq.scale >= 0 ? 1 + values[eq.scale][0] : 1.0;
  value = scale * length + (eq.additive_constant >= 0 ? values[eq.additive_constant][0] : 0.0);
  gradient = scale / length * reduced;
  return true;
}

bool evaluate_angle(const Equation& eq, const double* const* values, double& residual, const RowWriter& out) {
  const SightLine left = sight(eq, eq.to, eq.target_height, eq.rise, values);
  const SightLine right = sight(eq, eq.second_to, eq.second_target_height, eq.second_rise, values);
  double azimuth_left = 0, azimuth_right = 0;
  Vector3d gradient_left, gradient_right;
  if (!azimuth(left.d, azimuth_left, gradient_left) || !azimuth(right.d, azimuth_right, gradient_right)) return false;
  residual = wrap_angle(azimuth_right - azimuth_left - eq.value);
  add_sight_partials(eq, eq.second_to, right, gradient_right, out);
  add_sight_partials(eq, eq.to, left, -gradient_left, out);
  return true;
}

bool evaluate_equation(const Equation& eq, const double* const* values, double& residual, const RowWriter& out) {
  if (eq.kind == ObservationKind::angle) return evaluate_angle(eq, values, residual, out);
  const SightLine s = sight(eq, eq.to, eq.target_height, eq.rise, values);
  double value = 0, extra = 0;
  Vector3d gradient = Vector3d::Zero();
  switch (eq.kind) {
    case ObservationKind::direction:
    case ObservationKind::azimuth:
      if (!azimuth(s.d, value, gradient)) return false;
      if (eq.orientation >= 0) value -= values[eq.orientation][0];
      if (eq.collimation >= 0) {  // small: what it changes in the gradient is nothing
        const double steepness = eq.face * s.d.norm() / s.d.head<2>().norm();
        value += steepness * values[eq.collimation][0];
        out.add(eq.collimation, 1, 0, steepness);
      }
      residual = wrap_angle(value - eq.value);
      out.add(eq.orientation, 1, 0, -1.0);
      break;
    case ObservationKind::zenith_angle:
      if (!zenith_angle(eq, s, values, value, gradient, extra)) return false;
      if (eq.index >= 0) value += eq.index_factor * values[eq.index][0];
      residual = wrap_angle(value - eq.value);
      out.add(eq.index, 1, 0, eq.index_factor);
      out.add(eq.refraction, 1, 0, extra);
      break;
    case ObservationKind::slope_distance:
    case ObservationKind::horizontal_distance:
      if (!distance(eq, s.d, values, value, gradient, extra)) return false;
      residual = value - eq.value;
      out.add(eq.scale, 1, 0, extra);
      out.add(eq.additive_constant, 1, 0, 1.0);
      break;
    case ObservationKind::height_difference:
      residual = s.d.z() - eq.value;
      gradient = Vector3d::UnitZ();
      break;
    case ObservationKind::angle:
      return false;  // handled above
  }
  add_sight_partials(eq, eq.to, s, gradient, out);
  return true;
}

}  // namespace

bool ObservationBlock::evaluate(const double* const* values, double* residuals, double* const* jacobians) const {
  for (int r = 0; r < static_cast<int>(equations.size()); ++r)
    if (!evaluate_equation(equations[r], values, residuals[r], RowWriter{jacobians, r})) return false;
  return true;
}

bool CoordinateBlock::evaluate(const double* const* values, double* residuals, double* const* jacobians) const {
  for (int r = 0; r < static_cast<int>(equations.size()); ++r) {
    residuals[r] = values[equations[r].point][equations[r].axis] - equations[r].value;
    RowWriter{jacobians, r}.add(equations[r].point, 3, equations[r].axis, 1.0);
  }
  return true;
}

bool VectorBlock::evaluate(const double* const* values, double* residuals, double* const* jacobians) const {
  for (int v = 0; v < static_cast<int>(vectors.size()); ++v) {
    const Vector& vector = vectors[v];
    const Vector3d up = Vector3d::UnitZ(), to = Map<const Vector3d>(values[vector.to]) + vector.to_height * up,
                   from = Map<const Vector3d>(values[vector.from]) + vector.from_height * up;
    Eigen::Matrix3d by_to = Eigen::Matrix3d::Identity(), by_from = by_to;
    Vector3d d = map ? Vector3d(map->geocentric(to, &by_to) - map->geocentric(from, &by_from)) : to - from;
    // Where the geoid rises from one end to the other by t, the far end is t higher above the ellipsoid than it says.
    const Vector3d far_up = by_to.col(2);
    const Eigen::Vector2d along = (to - from).head<2>();
    if (slope >= 0) d += far_up * along.dot(Map<const Eigen::Vector2d>(values[slope]));
    for (int k = 0; k < 3; ++k) {
      const int r = 3 * v + k;
      residuals[r] = d[k] - observed[r];
      for (int c = 0; slope >= 0 && c < 2; ++c) RowWriter{jacobians, r}.add(slope, 2, c, far_up[k] * along[c]);
      for (int c = 0; c < 3; ++c) {
        if (by_to(k, c) != 0) RowWriter{jacobians, r}.add(vector.to, 3, c, by_to(k, c));
        if (by_from(k, c) != 0) RowWriter{jacobians, r}.add(vector.from, 3, c, -by_from(k, c));
      }
    }
  }
  return true;
}

bool LocalCoordinateBlock::evaluate(const double* const* values, double* residuals, double* const* jacobians) const {
  Vector3d d = Map<const Vector3d>(values[1]) - Map<const Vector3d>(values[0]);
  d.z() += target_height - instrument_height;
  d.head<2>() /= map_scale;
  const bool corrected = parameters.size() > 3;
  if (corrected) d.z() -= values[3][0];
  const double c = std::cos(values[2][0]), s = std::sin(values[2][0]);
  Eigen::Matrix3d rotation;
  rotation << c, -s, 0, s, c, 0, 0, 0, 1;
  Map<Vector3d> v(residuals);
  v = rotation * d - observed;
  for (int r = 0; r < 3; ++r) {
    const RowWriter out{jacobians, r};
    for (int k = 0; k < 3; ++k) {
      const double by_point = k < 2 ? rotation(r, k) / map_scale : rotation(r, k);
      out.add(1, 3, k, by_point);
      out.add(0, 3, k, -by_point);
    }
  }
  RowWriter{jacobians, 0}.add(2, 1, 0, -s * d.x() - c * d.y());
  RowWriter{jacobians, 1}.add(2, 1, 0, c * d.x() - s * d.y());
  if (corrected) RowWriter{jacobians, 2}.add(3, 1, 0, -1.0);
  return true;
}

bool PriorBlock::evaluate(const double* const* values, double* residuals, double* const* jacobians) const {
  const int n = static_cast<int>(prior.size());
  for (int r = 0; r < n; ++r) {
    residuals[r] = values[0][r] - prior[r];
    RowWriter{jacobians, r}.add(0, n, r, 1.0);
  }
  return true;
}

}  // namespace plumbline::survey

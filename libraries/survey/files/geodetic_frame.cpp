#include "survey/files/geodetic_frame.hpp"

#include <cmath>
#include <numbers>

#include "base/text/text.hpp"

namespace plumbline::survey {

namespace {

constexpr double kA = 6378137.0, kF = 1 / 298.257222101;  // GRS80
constexpr double kN = kF / (2 - kF), kE2 = kF * (2 - kF);
constexpr double kN2 = kN * kN, kN3 = kN2 * kN, kN4 = kN2 * kN2;
constexpr double kRadius = kA / (1 + kN) * (1 + kN2 / 4 + kN4 / 64);  // of the rectifying sphere
constexpr double kForward[] = {kN / 2 - 2 * kN2 / 3 + 5 * kN3 / 16 + 41 * kN4 / 180,
                               13 * kN2 / 48 - 3 * kN3 / 5 + 557 * kN4 / 1440, 61 * kN3 / 240 - 103 * kN4 / 140,
                               49561 * kN4 / 161280};
constexpr double kInverse[] = {kN / 2 - 2 * kN2 / 3 + 37 * kN3 / 96 - kN4 / 360, kN2 / 48 + kN3 / 15 - 437 * kN4 / 1440,
                               17 * kN3 / 480 - 37 * kN4 / 840, 4397 * kN4 / 161280};

/// Tangent of the conformal latitude.
double conformal(double tangent) {
  const double e = std::sqrt(kE2), root = std::hypot(1, tangent);
  const double s = std::sinh(e * std::atanh(e * tangent / root));
  return tangent * std::hypot(1, s) - s * root;
}

}  // namespace

Eigen::Vector2d TransverseMercator::forward(const Geodetic& p) const {
  const double t = conformal(std::tan(p.latitude)), l = p.longitude - meridian_;
  const double xi = std::atan2(t, std::cos(l)), eta = std::asinh(std::sin(l) / std::hypot(t, std::cos(l)));
  Eigen::Vector2d plane(eta, xi);
  for (int j = 0; j < 4; ++j) {
    const double k = 2 * (j + 1);
    plane +=
        kForward[j] * Eigen::Vector2d(std::cos(k * xi) * std::sinh(k * eta), std::sin(k * xi) * std::cosh(k * eta));
  }
  return scale_ * kRadius * plane;
}

Geodetic TransverseMercator::inverse(const Eigen::Vector2d& plane) const {
  const double eta = plane.x() / (scale_ * kRadius), xi = plane.y() / (scale_ * kRadius);
  double x = xi, e = eta;
  for (int j = 0; j < 4; ++j) {
    const double k = 2 * (j + 1);
    x -= kInverse[j] * std::sin(k * xi) * std::cosh(k * eta);
    e -= kInverse[j] * std::cos(k * xi) * std::sinh(k * eta);
  }
  const double wanted = std::sin(x) / std::hypot(std::sinh(e), std::cos(x));
  double t = wanted;  // contracts by e^2 each time
  for (int i = 0; i < 20; ++i) {
    const double step = (wanted - conformal(t)) / (1 - kE2);
    t += step;
    if (std::abs(step) < 1e-15 * std::hypot(1, t)) break;
  }
  return {std::atan(t), meridian_ + std::atan2(std::sinh(e), std::cos(x)), 0};
}

Geodetic from_utm(double east, double north, int zone, bool southern) {
  const TransverseMercator utm((6 * zone - 183) * std::numbers::pi / 180, 0.9996);
  return utm.inverse({east - 500000, southern ? north - 10000000 : north});
}

Geodetic from_geocentric(const Eigen::Vector3d& p) {
  const double h = p.head<2>().norm(), b = kA * (1 - kF);
  double reduced = std::atan2(p.z() * kA, h * b);
  double latitude = 0;
  for (int i = 0; i < 10; ++i) {
    const double s = std::sin(reduced), c = std::cos(reduced);
    latitude = std::atan2(p.z() + kE2 / (1 - kE2) * b * s * s * s, h - kE2 * kA * c * c * c);
    reduced = std::atan2((1 - kF) * std::sin(latitude), std::cos(latitude));
  }
  const double s = std::sin(latitude);
  const double height = h * std::cos(latitude) + p.z() * s - kA * std::sqrt(1 - kE2 * s * s);
  return {latitude, std::atan2(p.y(), p.x()), height};
}

GroundPlane::GroundPlane(const Geodetic& centre)
    : centre_(centre),
      scale_(1 + centre.height * (1 - kE2 * std::pow(std::sin(centre.latitude), 2)) / (kA * std::sqrt(1 - kE2))),
      projection_(centre.longitude, scale_),
      north_(projection_.forward(centre).y()) {}

std::string GroundPlane::as_map() const {
  const auto degrees = [](double rad) { return text::format_fixed(rad * 180 / std::numbers::pi, 13); };
  return "+proj=tmerc +lat_0=" + degrees(centre_.latitude) + " +lon_0=" + degrees(centre_.longitude) +
         " +k=" + text::format_fixed(scale_, 15) + " +x_0=0 +y_0=0 +ellps=GRS80 +units=m +type=crs";
}

Eigen::Vector3d GroundPlane::place(const Eigen::Vector3d& geocentric) const {
  Geodetic p = from_geocentric(geocentric);
  // Beside the centre, so that the meridian at 180 degrees does no harm.
  p.longitude = centre_.longitude + std::remainder(p.longitude - centre_.longitude, 2 * std::numbers::pi);
  const Eigen::Vector2d plan = (*this)(p);
  return {plan.x(), plan.y(), p.height};
}

Eigen::Matrix3d GroundPlane::change(const Eigen::Vector3d& geocentric) const {
  Eigen::Matrix3d columns;
  for (int k = 0; k < 3; ++k) {  // symmetric: a metre is nothing to the curvature of the earth
    const Eigen::Vector3d step = Eigen::Vector3d::Unit(k);
    columns.col(k) = 0.5 * (place(geocentric + step) - place(geocentric - step));
  }
  return columns;
}

Eigen::Vector2d GroundPlane::operator()(const Geodetic& p) const {
  return projection_.forward(p) - Eigen::Vector2d(0, north_);
}

}  // namespace plumbline::survey

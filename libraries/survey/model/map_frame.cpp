#include "survey/model/map_frame.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "survey/model/observation_equations.hpp"
#include "survey/words/network_words.hpp"

namespace plumbline::survey {

namespace {

Eigen::Vector3d middle_of(const std::vector<Eigen::Vector3d>& points) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  int heights = 0;
  for (const Eigen::Vector3d& p : points) {
    sum += Eigen::Vector3d(p.x(), p.y(), or_zero(p.z()));
    heights += !std::isnan(p.z());
  }
  const auto n = static_cast<double>(std::max<size_t>(1, points.size()));
  return {sum.x() / n, sum.y() / n, sum.z() / std::max(1, heights)};
}

}  // namespace

MapFrame::MapFrame(const std::string& system, const GeoidChoice& geoid, const Eigen::Vector2d& middle) : map_(system) {
  if (geoid.grid.empty())
    geoid_ = geodesy::Geoid(geoid.height, geoid.deflection,
                            geoid.deflection.isZero(0) ? geodesy::Place() : map_.inverse(middle));
  else
    geoid_ = geodesy::Geoid(std::make_shared<const geodesy::GeoidGrid>(geoid.grid));
}

double MapFrame::height_factor(const Eigen::Vector2d& at, double height) const {
  const geodesy::Place place = map_.inverse(at);
  const double radius = map_.radius(place);
  return radius / (radius + height + geoid_.height(place));
}

double MapFrame::scale(const Eigen::Vector3d& from, const Eigen::Vector3d& to) const {
  const Eigen::Vector3d middle = middle_of({from, to});
  // What is measured is the chord: c (1 + c^2 / 24 R^2) is its arc, 1 mm longer at 10 km and 1 m at 100 km.
  const double turn = (to - from).head<2>().norm() / kEarthRadius;
  return map_.line_scale(from.head<2>(), to.head<2>()) * height_factor(middle.head<2>(), middle.z()) *
         (1 + turn * turn / 24);
}

Eigen::Vector3d MapFrame::geocentric(const Eigen::Vector3d& at, Eigen::Matrix3d* jacobian) const {
  const auto place = [&](const Eigen::Vector3d& p) {
    const geodesy::Place on_ellipsoid = map_.inverse(p.head<2>());
    return map_.geocentric(on_ellipsoid, p.z() + geoid_.height(on_ellipsoid));
  };
  for (int k = 0; jacobian && k < 3; ++k) {  // symmetric: a metre is nothing to the curvature of map and earth
    const Eigen::Vector3d step = Eigen::Vector3d::Unit(k);
    jacobian->col(k) = 0.5 * (place(at + step) - place(at - step));
  }
  return place(at);
}

// Astronomic zenith minus geodetic: xi to the north, eta to the east. Seen at the azimuth A a zenith angle is smaller
// by xi cos A + eta sin A, a direction larger by (xi sin A - eta cos A) cot z, beside what all directions of a set-up
// share.
void MapFrame::add_deflection(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double& direction, double& zenith,
                              double& rise) const {
  const Eigen::Vector2d d = to.head<2>() - from.head<2>();
  rise = geoid_height(to.head<2>()) - geoid_height(from.head<2>());
  if (d.norm() < kShortestHorizontal) return;
  const geodesy::Place place = map_.inverse(from.head<2>());
  const Eigen::Vector2d deflection = geoid_.deflection(place);
  const double azimuth = std::atan2(d.x(), d.y()) + map_.factors(from.head<2>()).convergence;
  const double sine = std::sin(azimuth), cosine = std::cos(azimuth), up = or_zero(to.z() - from.z()) + rise;
  direction -= (deflection.x() * sine - deflection.y() * cosine) * up / d.norm();
  zenith += deflection.x() * cosine + deflection.y() * sine;
}

std::string MapFrame::geoid_in_words(const Eigen::Vector2d& at) const {
  constexpr double kSecond = std::numbers::pi / 180 / 3600;
  if (!has_deflection()) return "";
  const Eigen::Vector2d d = geoid_.deflection(map_.inverse(at)) / kSecond;
  return "; the geoid lies " + fixed_digits(geoid_height(at), 3) +
         " m above the ellipsoid, deflection of the vertical " + fixed_digits(d.x(), 1) + "\" to the north, " +
         fixed_digits(d.y(), 1) + "\" to the east";
}

std::string MapFrame::in_words(const std::vector<Eigen::Vector3d>& points) const {
  const Eigen::Vector3d middle = middle_of(points);
  const geodesy::MapFactors f = map_.factors(middle.head<2>());
  const double height = height_factor(middle.head<2>(), middle.z());
  return map_.name() + ": in the middle of the points scale " + fixed_digits(f.scale, 6) + ", height factor " +
         fixed_digits(height, 6) + ", together " + fixed_digits(f.scale * height, 6) + "; grid north " +
         fixed_digits(f.convergence * 200 / std::numbers::pi, 4) + " gon clockwise of true north" +
         geoid_in_words(middle.head<2>());
}

std::string map_that_explains(double factor, double sigma, const std::vector<Eigen::Vector3d>& points) {
  constexpr double kClose = 1.5e-5;  // what heights above the geoid in place of the ellipsoid, and a wide site, change
  constexpr double kLeast = 3e-5;    // less is a matter of ppm settings
  constexpr double kNearest = 1e5, kFarthest = 9e5;  // of an easting with a false one of 500 km [m]
  const Eigen::Vector3d middle = middle_of(points);
  const double in_zone = std::fmod(middle.x(), 1e6), zone = std::floor(middle.x() / 1e6);
  if (points.empty() || !(std::abs(factor - 1) > kLeast) || !(middle.y() > 1e5 && middle.y() < 1e7) ||
      !(middle.x() > kNearest))
    return "";
  const double height = kEarthRadius / (kEarthRadius + middle.z());
  const auto transverse = [&](double on_meridian) {
    const double y = (in_zone - 5e5) / on_meridian;
    return on_meridian * (1 + y * y / (2 * kEarthRadius * kEarthRadius)) * height;
  };
  const double utm = transverse(0.9996), gauss = transverse(1.0);
  const double allowed = std::max(kClose, 3 * sigma);
  const bool reaches = in_zone > kNearest && in_zone < kFarthest;
  const bool is_utm = reaches && std::abs(factor - utm) < allowed,
             is_gauss = reaches && std::abs(factor - gauss) < allowed;
  const std::string zone_words = zone > 0 ? " zone " + fixed_digits(zone, 0) : "";
  if (is_utm && !is_gauss)
    return "the coordinates look like UTM" + zone_words + ": the map shortens lengths there to " +
           fixed_digits(utm, 5) + ", which explains it. If they are, say which map it is: map=" +
           (zone > 0 ? "utm:" + fixed_digits(zone, 0) : std::string("utm:ZONE")) + " (or its EPSG code)";
  if (is_gauss && !is_utm)
    return "the coordinates look like Gauss-Krueger" + zone_words + ": the map draws lengths there at " +
           fixed_digits(gauss, 5) + ", which explains it. If they are, say which map it is: map=EPSG:CODE";
  return "the coordinates look like those of a national map, whose scale may explain it: if they are, say which: "
         "map=EPSG:CODE";
}

}  // namespace plumbline::survey

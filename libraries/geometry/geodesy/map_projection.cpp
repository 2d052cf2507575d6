#include "geometry/geodesy/map_projection.hpp"

#include <geodesic.h>
#include <proj.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

namespace plumbline::geodesy {

namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr const char* kExpected = "a map as 'EPSG:25832', 'utm:32', 'utm:19S' or by its name in the EPSG list";

struct Free {
  void operator()(PJ* p) const { proj_destroy(p); }
  void operator()(PJ_CONTEXT* c) const { proj_context_destroy(c); }
};
using Object = std::unique_ptr<PJ, Free>;

/// "utm:32" -> "EPSG:25832" where ETRS89 has the zone (28 to 38), else WGS 84; "utm:19S" -> "EPSG:32719".
std::string code_of(const std::string& system) {
  if (!system.starts_with("utm:") && !system.starts_with("UTM:")) return system;
  const bool south = system.back() == 'S' || system.back() == 's';
  int zone = 0;
  for (const char c : system.substr(4, system.size() - 4 - (south || system.back() == 'N' || system.back() == 'n'))) {
    if (c < '0' || c > '9' || zone > 60) return system;
    zone = 10 * zone + (c - '0');
  }
  if (zone < 1 || zone > 60) return system;
  return "EPSG:" + std::to_string(south ? 32700 + zone : zone >= 28 && zone <= 38 ? 25800 + zone : 32600 + zone);
}

}  // namespace

struct MapProjection::Impl {
  std::unique_ptr<PJ_CONTEXT, Free> context{proj_context_create()};
  Object to_map;      // longitude, latitude [deg] to east, north in the map's unit
  double metres = 1;  // of that unit
  geod_geodesic ellipsoid{};

  Object crs_of(const std::string& system) const {
    Object crs(proj_create(context.get(), code_of(system).c_str()));
    if (!crs) {  // by its name
      const PJ_TYPE types[] = {PJ_TYPE_PROJECTED_CRS};
      PJ_OBJ_LIST* found = proj_create_from_name(context.get(), nullptr, system.c_str(), types, 1, false, 1, nullptr);
      if (found && proj_list_get_count(found) > 0) crs.reset(proj_list_get(context.get(), found, 0));
      if (found) proj_list_destroy(found);
    }
    if (!crs) throw std::runtime_error("no map is known as '" + system + "'; expected " + kExpected);
    if (proj_get_type(crs.get()) == PJ_TYPE_COMPOUND_CRS) crs.reset(proj_crs_get_sub_crs(context.get(), crs.get(), 0));
    if (!crs || proj_get_type(crs.get()) != PJ_TYPE_PROJECTED_CRS)
      throw std::runtime_error("'" + system + "' is no map (it may have latitudes and longitudes); expected " +
                               kExpected);
    return crs;
  }

  /// Both axes east and north in any order, in one unit.
  void check_axes(const PJ* crs, const std::string& system) {
    const Object cs(proj_crs_get_coordinate_system(context.get(), crs));
    bool east = false, north = false;
    for (int axis = 0; axis < 2; ++axis) {
      const char* direction = nullptr;
      double factor = 1;
      proj_cs_get_axis_info(context.get(), cs.get(), axis, nullptr, nullptr, &direction, &factor, nullptr, nullptr,
                            nullptr);
      east = east || (direction && std::string(direction) == "east");
      north = north || (direction && std::string(direction) == "north");
      metres = factor;
    }
    if (!east || !north)
      throw std::runtime_error("the axes of '" + system + "' are not east and north; give a map whose axes are");
  }

  PJ_COORD transform(PJ_DIRECTION direction, double a, double b) const {
    PJ_COORD c = proj_trans(to_map.get(), direction, proj_coord(a, b, 0, 0));
    if (!std::isfinite(c.xy.x) || !std::isfinite(c.xy.y))
      throw std::runtime_error("a place is outside of the map: check east and north, and whether this is its map");
    return c;
  }
};

MapProjection::MapProjection(const std::string& system) : impl_(std::make_unique<Impl>()) {
  Impl& i = *impl_;
  proj_log_level(i.context.get(), PJ_LOG_NONE);
  proj_context_set_enable_network(i.context.get(), 0);
  const Object crs = i.crs_of(system);
  name_ = proj_get_name(crs.get());
  if (name_ == "unknown") name_ = system;  // written as "+proj=..."
  i.check_axes(crs.get(), system);
  const Object base(proj_crs_get_geodetic_crs(i.context.get(), crs.get()));
  const Object plain(proj_create_crs_to_crs_from_pj(i.context.get(), base.get(), crs.get(), nullptr, nullptr));
  if (plain) i.to_map.reset(proj_normalize_for_visualization(i.context.get(), plain.get()));
  if (!i.to_map) throw std::runtime_error("PROJ cannot draw the map '" + name_ + "'");
  const Object ellipsoid(proj_get_ellipsoid(i.context.get(), crs.get()));
  double a = 0, inverse_flattening = 0;
  proj_ellipsoid_get_parameters(i.context.get(), ellipsoid.get(), &a, nullptr, nullptr, &inverse_flattening);
  geod_init(&i.ellipsoid, a, inverse_flattening > 0 ? 1 / inverse_flattening : 0);
}

MapProjection::~MapProjection() = default;

bool MapProjection::is_geocentric() const {
  constexpr double kAxis = 6378137, kFlattening = 1 / 298.2572;
  return std::abs(impl_->ellipsoid.a - kAxis) < 5 && std::abs(impl_->ellipsoid.f / kFlattening - 1) < 1e-4;
}

Place MapProjection::inverse(const Eigen::Vector2d& map) const {
  const PJ_COORD c = impl_->transform(PJ_INV, map.x() / impl_->metres, map.y() / impl_->metres);
  return {c.xy.y * kDegree, c.xy.x * kDegree};
}

Eigen::Vector2d MapProjection::forward(const Place& place) const {
  const PJ_COORD c = impl_->transform(PJ_FWD, place.longitude / kDegree, place.latitude / kDegree);
  return impl_->metres * Eigen::Vector2d(c.xy.x, c.xy.y);
}

// From the images of four places around, whose distances on the ellipsoid are those of its curvatures.
MapFactors MapProjection::factors(const Eigen::Vector2d& map) const {
  constexpr double kStep = 2e-5;  // [rad], 130 m: rounding of a nanometre and curvature of the map both below 1e-10
  const Place at = inverse(map);
  const double f = impl_->ellipsoid.f, e2 = f * (2 - f), w2 = 1 - e2 * std::pow(std::sin(at.latitude), 2);
  const double meridian = impl_->ellipsoid.a * (1 - e2) / (w2 * std::sqrt(w2)),
               parallel = impl_->ellipsoid.a / std::sqrt(w2) * std::cos(at.latitude);
  const Eigen::Vector2d north =
      (forward({at.latitude + kStep, at.longitude}) - forward({at.latitude - kStep, at.longitude})) /
      (2 * kStep * meridian);
  const Eigen::Vector2d east =
      (forward({at.latitude, at.longitude + kStep}) - forward({at.latitude, at.longitude - kStep})) /
      (2 * kStep * parallel);
  const double scale = north.norm();
  if (std::abs(east.norm() / scale - 1) > 1e-7 || std::abs(north.dot(east)) > 1e-7 * scale * scale)
    throw std::runtime_error("the map '" + name_ +
                             "' is not conformal: how long it draws a line depends on its direction; give a conformal "
                             "one (UTM, Gauss-Krueger, Lambert conformal, stereographic)");
  // True north points to atan2(E, N) on the map; grid north lies as much on its other side.
  return {scale, -std::atan2(north.x(), north.y())};
}

double MapProjection::radius(const Place& place) const {
  const double f = impl_->ellipsoid.f, e2 = f * (2 - f), w2 = 1 - e2 * std::pow(std::sin(place.latitude), 2);
  return impl_->ellipsoid.a * std::sqrt(1 - e2) / w2;
}

Eigen::Vector3d MapProjection::geocentric(const Place& place, double height) const {
  const double f = impl_->ellipsoid.f, e2 = f * (2 - f), s = std::sin(place.latitude), c = std::cos(place.latitude);
  const double normal = impl_->ellipsoid.a / std::sqrt(1 - e2 * s * s);
  return {(normal + height) * c * std::cos(place.longitude), (normal + height) * c * std::sin(place.longitude),
          ((1 - e2) * normal + height) * s};
}

Eigen::Matrix3d MapProjection::horizon(const Place& place) {
  const double s = std::sin(place.latitude), c = std::cos(place.latitude), sl = std::sin(place.longitude),
               cl = std::cos(place.longitude);
  Eigen::Matrix3d axes;
  axes << -sl, cl, 0, -s * cl, -s * sl, c, c * cl, c * sl, s;
  return axes;
}

double MapProjection::line_scale(const Eigen::Vector2d& from, const Eigen::Vector2d& to) const {
  return (factors(from).scale + 4 * factors(0.5 * (from + to)).scale + factors(to).scale) / 6;
}

double MapProjection::arc_to_chord(const Eigen::Vector2d& from, const Eigen::Vector2d& to) const {
  const Place a = inverse(from), b = inverse(to);
  double azimuth = 0;
  geod_inverse(&impl_->ellipsoid, a.latitude / kDegree, a.longitude / kDegree, b.latitude / kDegree,
               b.longitude / kDegree, nullptr, &azimuth, nullptr);
  const double seen = azimuth * kDegree - factors(from).convergence;  // of the geodesic's image, from grid north
  const Eigen::Vector2d d = to - from;
  return std::remainder(std::atan2(d.x(), d.y()) - seen, 2 * std::numbers::pi);
}

}  // namespace plumbline::geodesy

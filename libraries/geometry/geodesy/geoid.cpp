#include "geometry/geodesy/geoid.hpp"

#include <proj.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

namespace plumbline::geodesy {

namespace {

constexpr double kEarthRadius = 6371000;  // [m]; slopes of a geoid are known to a hundredth of their size at best

struct Free {
  void operator()(PJ* p) const { proj_destroy(p); }
  void operator()(PJ_CONTEXT* c) const { proj_context_destroy(c); }
};

/// North and east of `from` [m].
Eigen::Vector2d north_east(const Place& from, const Place& to) {
  return kEarthRadius *
         Eigen::Vector2d(to.latitude - from.latitude,
                         std::remainder(to.longitude - from.longitude, 2 * std::numbers::pi) * std::cos(from.latitude));
}

}  // namespace

struct GeoidGrid::Impl {
  std::unique_ptr<PJ_CONTEXT, Free> context{proj_context_create()};
  std::unique_ptr<PJ, Free> shift;
};

GeoidGrid::GeoidGrid(const std::string& path) : impl_(std::make_unique<Impl>()), path_(path) {
  PJ_CONTEXT* context = impl_->context.get();
  proj_log_level(context, PJ_LOG_NONE);
  proj_context_set_enable_network(context, 0);
  if (path.find('"') != std::string::npos)
    throw std::runtime_error("the geoid grid " + path + " has a quotation mark in its name, which PROJ cannot take");
  const std::string pipeline = "+proj=vgridshift +grids=\"" + path + "\" +multiplier=1";
  impl_->shift.reset(proj_create(context, pipeline.c_str()));
  if (!impl_->shift)
    throw std::runtime_error(
        "the geoid grid " + path +
        " cannot be read; expected a grid of geoid heights as PROJ has them (.gtx, or GeoTIFF of cdn.proj.org)");
}

GeoidGrid::~GeoidGrid() = default;

double GeoidGrid::height(const Place& place) const {
  proj_errno_reset(impl_->shift.get());
  const PJ_COORD c = proj_trans(impl_->shift.get(), PJ_FWD, proj_coord(place.longitude, place.latitude, 0, 0));
  if (proj_errno(impl_->shift.get()) != 0 || !std::isfinite(c.lpz.z))
    throw std::runtime_error("latitude " + std::to_string(place.latitude * 180 / std::numbers::pi) + ", longitude " +
                             std::to_string(place.longitude * 180 / std::numbers::pi) + " is not in the geoid grid " +
                             path_ + ": take one that covers the site");
  return c.lpz.z;
}

Geoid::Geoid(double height, const Eigen::Vector2d& deflection, const Place& reference)
    : height_(height), deflection_(deflection), reference_(reference) {}

double Geoid::height(const Place& place) const {
  if (grid_) return grid_->height(place);
  return deflection_.isZero(0) ? height_ : height_ - deflection_.dot(north_east(reference_, place));
}

Eigen::Vector2d Geoid::deflection(const Place& place) const {
  if (!grid_) return deflection_;
  constexpr double kStep = 1000 / kEarthRadius;  // [rad]
  const double c = std::cos(place.latitude);
  const auto at = [&](double north, double east) {
    return grid_->height({place.latitude + north, place.longitude + east / c});
  };
  return Eigen::Vector2d(at(-kStep, 0) - at(kStep, 0), at(0, -kStep) - at(0, kStep)) / (2 * kStep * kEarthRadius);
}

}  // namespace plumbline::geodesy

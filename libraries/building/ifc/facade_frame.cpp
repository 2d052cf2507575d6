#include "building/ifc/facade_frame.hpp"

#include <fmt/core.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace plumbline::ifc {
namespace {

/// Steeper than this is a soffit or a roof: there is no up in its plane that follows from the vertical.
constexpr double kSteep = 0.97;
/// What the rounding of a file makes of a level direction.
constexpr double kLevel = 1e-6;

constexpr FacadeSource kSources[] = {FacadeSource::none,  FacadeSource::guess,    FacadeSource::wall,
                                     FacadeSource::panel, FacadeSource::own_axes, FacadeSource::plate,
                                     FacadeSource::rule};

}  // namespace

const char* name_of(FacadeSource source) {
  switch (source) {
    case FacadeSource::none:
      return "";
    case FacadeSource::guess:
      return "guess";
    case FacadeSource::wall:
      return "wall";
    case FacadeSource::panel:
      return "panel";
    case FacadeSource::own_axes:
      return "own_axes";
    case FacadeSource::plate:
      return "plate";
    case FacadeSource::rule:
      return "rule";
  }
  return "";
}

FacadeSource facade_source(const std::string& name) {
  for (const FacadeSource source : kSources)
    if (name == name_of(source)) return source;
  return FacadeSource::none;
}

FacadeFrame frame_facing(const Eigen::Vector3d& out, FacadeSource source, bool confirmed,
                         const Eigen::Vector3d& up_hint) {
  FacadeFrame frame;
  frame.out = out.normalized();
  if (std::abs(frame.out.z()) < kLevel) frame.out = Eigen::Vector3d(frame.out.x(), frame.out.y(), 0).normalized();
  Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  if (std::abs(frame.out.z()) > kSteep) {
    const bool hinted = up_hint.allFinite() && up_hint.cross(frame.out).norm() > 0.1 * up_hint.norm();
    up = hinted ? up_hint : Eigen::Vector3d::UnitY();
  }
  frame.up = (up - frame.out.dot(up) * frame.out).normalized();
  frame.right = frame.up.cross(frame.out);
  frame.source = source, frame.confirmed = confirmed;
  return frame;
}

Eigen::Vector3d facing(double azimuth, double tilt) {
  return {std::cos(tilt) * std::sin(azimuth), std::cos(tilt) * std::cos(azimuth), std::sin(tilt)};
}

double azimuth_degrees(const Eigen::Vector3d& out) {
  const double degrees = std::atan2(out.x(), out.y()) * 180 / std::numbers::pi;
  return degrees < -1e-9 ? degrees + 360 : std::max(0.0, degrees);
}

std::string facing_words(const Eigen::Vector3d& out) {
  if (!out.allFinite()) return "unknown";
  if (std::abs(out.z()) > kSteep) return out.z() > 0 ? "up" : "down";
  const double tilt = std::asin(std::clamp(out.z(), -1.0, 1.0)) * 180 / std::numbers::pi;
  const double azimuth = std::fmod(std::round(10 * azimuth_degrees(out)) / 10, 360.0);
  if (std::abs(tilt) < 0.5) return fmt::format("{:.4g}°", azimuth);
  return fmt::format("{:.4g}° and {:.2g}° {}", azimuth, std::abs(tilt), tilt > 0 ? "up" : "down");
}

}  // namespace plumbline::ifc

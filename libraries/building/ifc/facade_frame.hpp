// Which way an anchor or panel of a design faces, and what says so.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <string>

namespace plumbline::ifc {

/// What says which way something faces, the weakest first.
enum class FacadeSource {
  none,      ///< nothing does
  guess,     ///< how the anchors lie and where the rest of the building stands
  wall,      ///< the wall or slab that it is fixed to
  panel,     ///< the plane of the panel it holds (its own, of a panel), and on which side that hangs
  own_axes,  ///< its placement: x to the right as one looks at it, z up, so that y leads into the building
  plate,     ///< the azimuth of the marker plate at the anchor
  rule       ///< a rule or table of the user
};
const char* name_of(FacadeSource source);
/// The inverse; none for what is no source.
FacadeSource facade_source(const std::string& name);

/// Axes of one who stands before an element: unit vectors, right = up × out, in the frame of the design. Of a facade
/// that leans, `up` leans with it; of a soffit or a roof, `up` lies in its plane.
struct FacadeFrame {
  static constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  Eigen::Vector3d right = Eigen::Vector3d::Constant(nan), up = Eigen::Vector3d::Constant(nan),
                  out = Eigen::Vector3d::Constant(nan);  ///< nan: nothing says which way it faces
  FacadeSource source = FacadeSource::none;
  /// Whether orders (outward, to the right) may be given by it. False for a guess, and where two sources contradict.
  bool confirmed = false;
  std::string facade;  ///< name of the facade it belongs to
  bool named = false;  ///< that name is the user's
  std::string note;    ///< why it is not confirmed

  bool known() const { return out.allFinite(); }
};

/// The frame of what faces `out` (need not be a unit vector). `up_hint`: upward in the plane where `out` is nearly
/// vertical; nan or along `out`: the y axis of the design.
FacadeFrame frame_facing(const Eigen::Vector3d& out, FacadeSource source, bool confirmed,
                         const Eigen::Vector3d& up_hint = Eigen::Vector3d::Constant(FacadeFrame::nan));

/// Unit vector of an azimuth, clockwise from the y axis, and a tilt above the horizontal [rad].
Eigen::Vector3d facing(double azimuth, double tilt = 0);
/// Azimuth of a direction, clockwise from the y axis, 0 to 360 [deg].
double azimuth_degrees(const Eigen::Vector3d& out);
/// "180°", "down", "up", "190° and 10° down".
std::string facing_words(const Eigen::Vector3d& out);

}  // namespace plumbline::ifc

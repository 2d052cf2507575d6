// The simulated building: a facade with anchors on the grid of the paper's Table 1, what the design says of them and
// how they were really built, and the marker plate that hangs at each.
//
// Building frame [m]: x along the facade to the right as one looks at it, y into the building (cameras and set-ups
// stand at negative y), z up. Survey axes E, N, H are x, y, z. Buildings of several facades: wings.hpp.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "geometry/marker_plate.hpp"
#include "perturbations.hpp"
#include "plumbline/rigid_transform.hpp"

namespace plumbline::simulate {

struct BuildingOptions {
  int floors = 3;                       ///< 1 ... 20
  int columns = 4;                      ///< 2 ... 12 columns of control anchors, 2 rows a floor
  double spacing = 2.0;                 ///< of the grid, horizontally and vertically [m]; a storey is two rows, 4 m
  double as_built_sigma = 3e-3;         ///< deviation of an anchor from its design, each axis [m]
  double plate_tilt_sigma = 0.025;      ///< rotation of a plate out of the facade, each axis [rad]
  double tag_size = 0.2;                ///< nominal edge between the detected corners [m]
  double tag_scale_sigma = 0.05 / 200;  ///< error of a print batch, relative: 0.05 mm of 200 mm
  int print_batches = 1;                ///< plates are printed in so many batches, floor by floor
  Perturbations flaws = {};             ///< of prints and plates
};

enum class AnchorRole {
  control,  ///< surveyed, and may hold the model
  check     ///< surveyed, but withheld from control
};
const char* to_string(AnchorRole role);  ///< "control", "check"

struct Anchor {
  std::string id;  ///< "F02-C03-R1": floor, column, row from the left and below; check anchors "F02-K1"
  int floor = 0;   ///< from 1 at the bottom
  int column = 0;  ///< vertical line it hangs in, from 1; those of check anchors follow those of control
  int row = 0;     ///< from 1 within the floor; 0 for a check anchor
  AnchorRole role = AnchorRole::control;
  Eigen::Vector3d design = Eigen::Vector3d::Zero();  ///< [m], building frame
  Eigen::Vector3d built = Eigen::Vector3d::Zero();   ///< truth [m], building frame

  int wing = 0;  ///< index into Building::wings
  int tag_id = 0;
  int batch = 0;                       ///< print batch of the plate, from 0
  RigidTransform building_from_plate;  ///< truth
  MarkerPlate true_plate;              ///< with the size the printer really gave
  double bend = 0;  ///< the tag's upper right and lower left corner lie this much above its plane, the others below [m]
  /// The surveyed target: the plate's origin, which mounting has moved off the anchor [m].
  const Eigen::Vector3d& target() const { return building_from_plate.translation; }
  /// Corners of the tag in the plate frame [m].
  std::array<Eigen::Vector3d, 4> tag_corners() const;
};

struct Building {
  BuildingOptions options;
  double storey_height = 0;         ///< [m]
  double width = 0;                 ///< of the facade, from x = 0 [m]
  double height = 0;                ///< from z = 0 [m]
  MarkerPlate nominal_plate;        ///< as the table of plates says
  std::vector<double> batch_scale;  ///< true over nominal tag size
  std::vector<Anchor> anchors;      ///< by facade, then by floor, control before check
  /// Frames of its facades: each lies in x and z of its own, from x = 0 to `width`, and faces -y. One, the building's
  /// own, unless it has a shape (wings.hpp).
  std::vector<RigidTransform> wings = {RigidTransform{}};
};

/// Whether no facade but `own_wing` stands between two places.
bool free_sight(const Building& building, const Eigen::Vector3d& from, const Eigen::Vector3d& to, int own_wing = -1);

/// Orientation of a plate that hangs upright and flat on the facade: its z axis points to the cameras (-y).
Eigen::Quaterniond facade_from_plate();

/// The building of a seed; equal options and seed give equal numbers. Throws std::invalid_argument for options out of
/// bounds.
Building make_building(const BuildingOptions& options, std::uint64_t seed);

/// Centre of the outer edge of the plate's parts in the plate frame [m]: half extent in x, and y from bottom to top.
struct PlateOutline {
  double half_width = 0, bottom = 0, top = 0;
  double target_radius = 0;  ///< of the survey target's ring
};
PlateOutline plate_outline(const MarkerPlate& plate);

}  // namespace plumbline::simulate

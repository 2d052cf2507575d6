// A marker plate: one printed fiducial tag and one survey target on a rigid plate that is fixed at an anchor.
//
// Plate frame [m]: origin at the survey target, which stands for the anchor; x to the right and y up as one looks at
// the plate, z out of the plate towards the viewer. The tag lies in the plane z = 0 with its upright axes along x and
// y.
#pragma once

#include <Eigen/Core>
#include <array>

namespace plumbline {

struct MarkerPlate {
  double tag_size = 0;                                            ///< edge between the detected corners [m]
  Eigen::Vector3d tag_centre_in_plate = Eigen::Vector3d::Zero();  ///< [m]
};

/// Corners of a tag in the order that observations use: bottom left, bottom right, top right, top left of the upright
/// tag (libapriltag's order), in the plate frame [m].
inline std::array<Eigen::Vector3d, 4> tag_corners_in_plate(const MarkerPlate& plate) {
  const double h = 0.5 * plate.tag_size;
  const Eigen::Vector3d& c = plate.tag_centre_in_plate;
  return {c + Eigen::Vector3d(-h, -h, 0), c + Eigen::Vector3d(h, -h, 0), c + Eigen::Vector3d(h, h, 0),
          c + Eigen::Vector3d(-h, h, 0)};
}

}  // namespace plumbline

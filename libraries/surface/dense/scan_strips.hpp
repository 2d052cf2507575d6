// Whether a scan lies beside its place by a part of a panel: its joints run through the panels then, and where the
// design has joints it has none. (Beside it by whole panels: scan_shift.hpp.)
#pragma once

#include <string>
#include <vector>

#include "surface/dense/joint.hpp"
#include "surface/dense/measured_points.hpp"

namespace plumbline::surface {

/// Middles of strips, 8 to 60 mm wide, without a point of the panel's surface from one end of it to the other [m, from
/// the panel's middle].
struct EmptyStrips {
  std::vector<double> right;  ///< of upright ones
  std::vector<double> up;     ///< of those across
};

/// `surface`: of the face, measured. None where points are too few to tell, 20 in 4 mm of the panel, or stand in lines.
EmptyStrips empty_strips(const PanelFace& face, const PanelSurface& surface, const std::vector<MeasuredTile>& tiles);

/// Whether so many joints of one direction are closed over most of their length that strips are worth looking for.
bool closed_joints(const std::vector<Joint>& joints, const std::vector<MeasuredJoint>& found);

/// Says so, with where the strips run, if half of the joints of a direction are closed and strips lie at the same place
/// in a third of the panels, two or more; else empty. `strips`: by panel.
std::string beside_its_place(const std::vector<EmptyStrips>& strips, const std::vector<Joint>& joints,
                             const std::vector<MeasuredJoint>& found);

}  // namespace plumbline::surface

// Joints between panels from the points of a scan: the borders of both panels, width and flush step along the joint
// with their standard deviations.
//
// A scan never measures an edge: its points end somewhere before it. What is looked for at each place along the joint
// is where points stop to lie on one panel's surface and where those on the other's begin. The edge itself lies between
// the last point and the next one that there would have been. How far that is the panel's own points say, a little away
// from its border: they are cut at every place, as an edge would cut them, and the mean and the variance of what is
// missing then are those of the edge. So nothing is supposed of the pattern that the scanner draws: of points at random
// with a mean distance d along the joint's profile the edge lies d ± d beyond the last one, of columns s apart
// s/2 ± s/√12.
//
// A beam that meets the edge comes back from the panel and from what lies behind it. Scanners that take the first of
// them see the panel up to half a beam too wide, those that take the mean half a beam too narrow: both edges alike, and
// all joints of a scan. That is in the standard deviation, as everything between is as likely, and no number of points
// makes it better.
#pragma once

#include <vector>

#include "surface/dense/joint.hpp"
#include "surface/dense/measured_points.hpp"

namespace plumbline::surface {

struct ScanJointOptions {
  double station = 0.05;  ///< length along the joint of which points are taken together [m]
  double search = 0.012;  ///< how far an edge may be from where the design has it [m]
  double beam = 0.006;    ///< diameter of the scanner's beam on the panels; 0: a point without extent [m]
  double strip = 0.04;    ///< of a panel beside its edge, whose points say how densely they stand [m]
  double off = 4;         ///< points so many times their noise from a panel's surface are not on it
};

/// `surfaces`: of the faces, in their order, measured in the same points. `tiles`: all that have points near the joint;
/// they have to reach beyond the faces by at least `search` (ScanTiles, `beyond`), else edges are where the design's
/// are.
MeasuredJoint measure_scan_joint(const Joint& joint, const std::vector<PanelFace>& faces,
                                 const std::vector<PanelSurface>& surfaces, const std::vector<MeasuredTile>& tiles,
                                 const ScanJointOptions& options);

/// What is missing of a row of places [m] if it is cut anywhere between its first and its last: from the cut back to
/// the last place before it.
struct CutOff {
  double mean = 0, variance = 0;  ///< [m], [m²]
  double largest = 0;             ///< the largest step between neighbours [m]
};
/// `places`: in order, two or more. Between neighbours d apart a cut falls with a chance that goes with d.
CutOff cut_off(const std::vector<double>& places);

}  // namespace plumbline::surface

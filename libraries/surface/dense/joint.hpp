// Joints between panels, measured in the photographs: both edges as sub-pixel positions in every photograph that sees
// them, width and flush step along the joint with their standard deviations.
//
// What is measured is the edge that is seen: where the panel's face turns away. A bevel or a bead of sealant belongs to
// the joint as it is lit.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <string>
#include <vector>

#include "surface/dense/facet.hpp"
#include "surface/dense/panel_surface.hpp"

namespace plumbline::surface {

/// A joint of the design. `plane`: origin in the joint's middle; right is across the joint from panel `a` to `b`, up is
/// along it, out as the facade, of panels at an angle as the mean of both.
struct Joint {
  std::string a, b;               ///< ids of the panels; `a` lies at negative right
  size_t face_a = 0, face_b = 0;  ///< numbers of their faces
  FacadePlane plane;
  double width = 0;     ///< nominal [m]
  double length = 0;    ///< [m]
  double step = 0;      ///< of b over a in the design [m]
  bool upright = true;  ///< runs upwards on the facade; else across
};

struct JointOptions {
  double station = 0.02;       ///< length along the joint that one station takes the mean of [m]
  double search = 0.012;       ///< how far an edge is looked for from where the design has it [m]
  int min_views = 2;           ///< photographs that have to show an edge
  double height_sigma = 3e-4;  ///< of the edge over the panel's fitted surface: bevels, dents [m]
  /// Of the edge of a panel that was not measured, from where the design has it: large enough that the photographs say
  /// where it is, and not the design [m].
  double unmeasured_height_sigma = 0.02;
};

struct JointStation {
  double along = 0;                   ///< from the joint's middle [m]
  double width = 0, width_sigma = 0;  ///< [m]; sigma has all of the parts that follow
  double width_random = 0;            ///< what differs from station to station [m]
  /// By the heights of both edges, each by its standard deviation: alike in all stations of a joint [m].
  Eigen::Vector2d width_by_edge = Eigen::Vector2d::Zero();
  Eigen::RowVectorXd width_by_orientation;  ///< in the order of OrientationCovariance
  double step = 0, step_sigma = 0;          ///< b over a, out of the facade [m]; nan if a panel was not measured
  /// The joint's middle from where the design has it, from a towards b: neighbours that moved together have joints as
  /// wide as designed. nan: nobody says how well the place of the points is known [m].
  double shift = std::numeric_limits<double>::quiet_NaN(), shift_sigma = shift;
  int views = 0;  ///< photographs that show both edges, or the fewer of the two
};

struct MeasuredJoint {
  size_t joint = 0;          ///< which one
  std::string not_measured;  ///< why it has no station
  std::vector<JointStation> stations;
  int stations_looked_at = 0;
  /// Places where no gap is to be seen between the panels: filled flush there, closed, or hidden. Of a scan where both
  /// panels have points closely, two or more in a row; of photographs where enough of them look and show no edge, over
  /// 60 mm.
  int closed = 0;
  /// Places of photographs where something stands before an edge, as the panels' points show: not measured.
  int covered = 0;
  size_t narrowest = 0, widest = 0, largest_step = 0, largest_shift = 0;  ///< stations, if there are any
};

/// `surfaces`: of the faces, in their order. Orientations: what is common to all stations.
MeasuredJoint measure_joint(const Joint& joint, const std::vector<PanelFace>& faces,
                            const std::vector<PanelSurface>& surfaces, const std::vector<FacetView>& views,
                            const OrientationCovariance& orientations, const JointOptions& options);

}  // namespace plumbline::surface

// What points say of one panel: its plane, bow and twist with their covariance, and how flat it is under a
// straightedge.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "surface/dense/facade_plane.hpp"
#include "surface/dense/measured_points.hpp"

namespace plumbline::surface {

using Vector6 = Eigen::Matrix<double, 6, 1>;

/// Where a panel should be: its outer face, a rectangle about the plane's origin.
struct PanelFace {
  std::string id;
  FacadePlane plane;  ///< origin in the middle of the outer face, axes right, up, out
  double width = 0;   ///< along right [m]
  double height = 0;  ///< along up [m]
  double thickness = std::numeric_limits<double>::quiet_NaN();  ///< of the panel behind the face [m]
};

struct PanelOptions {
  double border = 0.02;  ///< points nearer to the panel's edge are not its own: joints, bevels [m]
  double reach = 0.1;    ///< points further from the design's face are not the panel's [m]
  int least_points = 12;
  double least_coverage = 0.3;  ///< share of the face, in cells, that has to have points
  double cell = 0.05;           ///< of coverage and flatness [m]
  double most_scatter = 5;  ///< points that scatter more than so many times their sigmas and more than `least_scatter`
  double least_scatter = 0.0005;                   ///< are no surface: glass, a mirror, something else in front [m]
  std::vector<double> straightedges = {0.1, 1.0};  ///< lengths to look under [m]
  /// Whether neighbouring points have errors of their own, as a scanner's have; facets of photographs share pixels.
  bool independent = false;
  /// How far from the design's face the points were collected, if they know no better themselves [m].
  double search = std::numeric_limits<double>::infinity();
};

/// The largest gap under a straightedge of one length that rests on the surface's two highest places beneath it, as
/// DIN 18202 measures flatness. Estimated from the means of cells; the largest of many gaps of a noisy surface is too
/// large rather than too small. By how much at most, the noise alone says: with true heights h and errors e every gap
/// is linear in h + e between given places, so that the largest of all is at most the largest of h and the largest of
/// e.
struct Gap {
  double length = 0;                                ///< of the straightedge [m]
  double gap = 0;                                   ///< [m]
  double sigma = 0;                                 ///< random and systematic [m]
  Eigen::Vector2d place = Eigen::Vector2d::Zero();  ///< of the gap on the panel, from its middle [m]
  int positions = 0;       ///< of the straightedge that were looked at; 0: the surface has none of that length
  double noise_mean = 0;   ///< of the largest gap that the cells' errors alone make, by simulation [m]
  double noise_sigma = 0;  ///< its standard deviation, with the systematic part of `sigma` [m]
  /// The largest gap with places whose points lie off the surface together: a dent, or something in front. nan: none do
  /// [m]
  double with_outlying = std::numeric_limits<double>::quiet_NaN();
};

/// h = c0 + c1 x + c2 y + c3 (1 − x²) + c4 (1 − y²) + c5 x y, with x and y from −1 to 1 over the panel.
struct PanelSurface {
  std::string id;
  std::string not_measured;  ///< why there are no figures; empty if there are
  int points = 0, outliers = 0;
  double coverage = 0;  ///< share of the face's cells with points
  /// Distance between neighbouring points, if they were spread evenly over the panel [m].
  double spacing = std::numeric_limits<double>::quiet_NaN();
  /// Where so few cells have points because points are that far apart: the edge of cells that would have points
  /// everywhere [m]; nan: the cells are not why.
  double covering_cell = std::numeric_limits<double>::quiet_NaN();
  double rms = 0;              ///< of the points about the surface [m]
  double variance_factor = 1;  ///< of the points' own sigmas; they were widened by it where it is above 1
  /// How often each place has a point, on average: 2 of a cloud that was put into its file twice. Such points say
  /// nothing new, and variances are larger by it.
  double repeated = 1;
  /// The best plane: out of the design's face at the panel's middle [m], and its slopes by right and up.
  Eigen::Vector3d plane = Eigen::Vector3d::Zero();
  Eigen::Matrix3d plane_random = Eigen::Matrix3d::Zero(), plane_systematic = Eigen::Matrix3d::Zero();
  Eigen::Matrix<double, 3, Eigen::Dynamic> plane_factor;  ///< of the systematic part, by the cloud's z
  /// c0 … c5 [m]: bow across and up are c3 and c4 (the middle over the edges), twist is c5 (a corner over the plane).
  Vector6 form = Vector6::Zero();
  Eigen::Matrix<double, 6, 6> form_random = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Matrix<double, 6, Eigen::Dynamic> form_factor;  ///< of the systematic part, by the cloud's z
  /// Waves, grooves or dents smaller than the cells that flatness takes the means of, valley to crest
  /// (hidden_in_cells()) [m].
  double hidden = 0;
  double half_width = 0, half_height = 0;  ///< of the panel: x = u / half_width, y = v / half_height
  /// How far the surface as it is lies off that form at the left, right, lower and upper edge, rms beyond what noise
  /// makes: bent edges, waves. A height at an edge is no surer than that [m].
  Eigen::Vector4d edge_misfit = Eigen::Vector4d::Zero();
  /// Middles of cells where points lie together before the surface: something stands before the panel there, and may be
  /// taken for its edge. From the panel's middle [m].
  std::vector<Eigen::Vector2d> before;
  double cell = 0.05;  ///< edge of those cells [m]
  std::vector<Gap> flatness;
  Eigen::Matrix3d plane_covariance() const { return plane_random + plane_systematic; }
  Eigen::Matrix<double, 6, 6> form_covariance() const { return form_random + form_factor * form_factor.transpose(); }
  /// The base functions at (u, v) from the panel's middle [m]: their product with `form` is the surface's height there.
  Vector6 base(double u, double v) const;
};

/// Takes the panel's own points out of all tiles and fits them robustly. Figures of what has too few points or covers
/// too little of the face are not given: `not_measured` says why.
PanelSurface measure_panel(const PanelFace& face, const std::vector<MeasuredTile>& tiles, const PanelOptions& options);

}  // namespace plumbline::surface

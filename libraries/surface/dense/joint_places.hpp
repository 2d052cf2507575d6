// What joints have in common, whoever measured their edges: heights of the panels at them, steps, and which places of a
// joint are believed.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "surface/dense/joint.hpp"

namespace plumbline::surface {

/// One edge of a joint in the joint's own plane: u of its place is looked for around `nominal`.
struct EdgeLine {
  double nominal = 0;  ///< [m]
  const PanelFace* face = nullptr;
  const PanelSurface* surface = nullptr;
};

/// Of panels a and b. A panel without a surface has none.
std::array<EdgeLine, 2> edge_lines(const Joint& joint, const std::vector<PanelFace>& faces,
                                   const std::vector<PanelSurface>& surfaces);

/// Height of the panel's surface over the joint's plane at a place of that plane, and what it is a product of; the
/// design's height where the panel has no figures.
struct EdgeHeight {
  double height = 0;  ///< [m]
  double design = 0;  ///< of the design's face there [m]
  /// Of its random part, with what the surface lacks at that edge: what the orientations do to it they do to the
  /// neighbour's too [m²].
  double variance = 0;
  Vector6 base = Vector6::Zero();
  bool measured = false;
};
EdgeHeight height_at(const EdgeLine& line, const FacadePlane& plane, double u, double v);

/// Step of b over a at the edges' places, beyond what the design has there, with both parts of the covariance; nan if a
/// panel was not measured.
void add_step(JointStation& station, const EdgeLine& line_a, const EdgeLine& line_b, const FacadePlane& plane, double a,
              double b);

/// Both edges at a station: places and variances of their random part.
struct EdgePair {
  double u[2], variance[2];
};

/// Leaves out stations whose edges are not on the lines of the others, within `bow` [m]: what looked like an edge.
/// Where `run` neighbours or more are off to the same side, the panel's edge is there, and they stay. What merely
/// shifts an edge, grain of a panel in all photographs alike, no fit shows; what it does is seen in how the stations
/// scatter about the line, and the random part is widened to that. `edges`: of the stations, in their order.
void keep_straight(MeasuredJoint& measured, const std::vector<EdgePair>& edges, double bow, size_t run);

/// Whether points of one of the panels show something before it within `reach` along the joint [m] and a cell and a
/// half across, whose border photographs would take for the panel's.
bool is_covered(const std::array<EdgeLine, 2>& lines, const FacadePlane& plane, double along, double reach);

/// A place along a joint as photographs saw it.
struct LookedAt {
  double along = 0;     ///< from the joint's middle [m]
  bool looked = false;  ///< enough photographs have it in them
  bool edge = false;    ///< and show one edge at least
};

/// How many places lie in stretches of 60 mm or more where photographs look and no edges show: panels that touch, or a
/// joint that is filled flush. Within a stretch grain may look like an edge at less than half of the places.
/// `believed`: stations with both edges, in order, of which none lies in a stretch.
int without_edges(const std::vector<LookedAt>& places, const std::vector<JointStation>& believed);

/// Which station is narrowest, widest, has the largest step or shift; no figures at all if fewer than half of the
/// stations that were looked at have any. `what`: of how many of them the reason speaks, "two straight edges show".
void sum_up(MeasuredJoint& measured, const std::string& what);

}  // namespace plumbline::surface

// Where surfaces should be: the panels of a design, or the plane of some points.
#pragma once

#include <memory>
#include <set>
#include <string>
#include <vector>

#include "artifacts/design.hpp"
#include "artifacts/points.hpp"
#include "artifacts/surface_points.hpp"
#include "surface/dense/panel_surface.hpp"

namespace plumbline::surface {

struct Faces {
  std::vector<PanelFace> faces;
  std::vector<std::string> guids;         ///< of the elements, one a face
  std::vector<SurfaceLeftOutT> left_out;  ///< panels without a face
  std::vector<std::string> guessed;       ///< panels whose outer side nobody confirms
};

/// "P1: nothing looks at it ..."
inline std::string in_words(const SurfaceLeftOutT& panel) { return panel.id + ": " + panel.reason; }
/// The same for an artifact.
std::vector<std::unique_ptr<SurfaceLeftOutT>> copies_of(const std::vector<SurfaceLeftOutT>& panels);

/// GlobalIds of what panels are parts of (a curtain wall of its plates): its parts are looked at, not itself.
std::set<std::string> wholes_of_panels(const DesignT& design);

/// Of x, y, z one after the other [m]. Throws std::runtime_error for another number of values.
std::vector<Eigen::Vector3d> stations_of(const std::vector<double>& values);

/// Places that look at a plane from before it and from behind it, at no flatter an angle than 15°.
struct Lookers {
  int before = 0, behind = 0;
};
Lookers looked_at(const Eigen::Vector3d& origin, const Eigen::Vector3d& out,
                  const std::vector<Eigen::Vector3d>& seen_from);

/// Outer faces of the design's panels, each by itself: of the box of its shape the side that faces out of the facade
/// (DesignElement.facade), as wide as the design's own outer side (DesignElement.rectangles), where that is confirmed;
/// else the side of the two larger extents that `seen_from` (projection centres, scanner stations) look at. A panel
/// that is looked at from both sides, as it is in a block around a building, or from none, is turned as its unconfirmed
/// frame says if nothing contradicts it, or as the design's one facade; else it is left out, because nobody knows which
/// side is outside. So is one whose outer side the design itself makes no plane (a curved or folded panel), with by how
/// much, or no rectangle, and of wholes of other panels nothing is said. Panels that share a name are called "NAME
/// [tag]", where tags tell them apart, else "NAME [GlobalId]".
Faces faces_of(const DesignT& design, const std::vector<Eigen::Vector3d>& seen_from);

/// Leaves out faces that some of `seen_from` look at and all from behind: what they see is another side of the panel.
void leave_out_seen_from_behind(Faces& faces, const std::vector<Eigen::Vector3d>& seen_from);

/// One face: the best plane of the points, wide enough to hold them and `margin` more, turned to `seen_from`. Throws
/// std::runtime_error for fewer than three points or points on a line, and where as many look from one side as from the
/// other, or nobody does.
Faces face_through(const PointsT& points, const std::vector<Eigen::Vector3d>& seen_from, double margin);

}  // namespace plumbline::surface

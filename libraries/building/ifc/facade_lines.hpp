// What one shape of a design says of a facade: a line across it, and perhaps which of its ends is outside.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "building/ifc/design.hpp"

namespace plumbline::ifc {

/// Nearer to its panel's middle plane than this an anchor does not tell on which side the panel hangs [m].
inline constexpr double kBeside = 0.02;
/// An anchor within this of the face of a wall or slab is fixed to that face [m].
inline constexpr double kAtFace = 0.5;

/// A line across the facade, and which of its ends is outside, where that is known: then it points there.
struct FacadeLine {
  Eigen::Vector3d direction;
  bool outward = false;
  bool may_hang = false;  ///< of a wall that stands beside the anchor: it may be a precast panel before it
};

/// Within 20° of one line; unit vectors.
bool alike(const Eigen::Vector3d& a, const Eigen::Vector3d& b);
/// The same, and not the opposite of each other.
bool same_way(const Eigen::Vector3d& a, const Eigen::Vector3d& b);
/// Its own axes in the frame of the project, as columns.
Eigen::Matrix3d axes_of(const Element& element);
/// Outward by the placement: −y of axes whose z points up. None: a bolt drawn along z and laid down.
std::optional<Eigen::Vector3d> own_direction(const Element& element);
/// The thin axis of a box, 0 to 2; nothing if it is not flat.
std::optional<int> thin_axis(const Element& element);
/// Of its box, project frame [m].
Eigen::Vector3d middle_of(const Element& element);
/// The side of a wall, or the edge of a slab, that an anchor at `anchor` (project frame) sits at.
std::optional<FacadeLine> line_of_host(const Element& host, const Eigen::Vector3d& anchor);
/// What carries a building: an anchor that sits at its edge is fixed to it, whether the file says so or not.
bool carries(const Element& element);
/// The side of `line` on which the edges of slabs and walls say the outside is, +1 or −1; 0 if none does, or they
/// contradict one another, or only what may hang says so.
int side_of_edges(const std::vector<FacadeLine>& edges, const Eigen::Vector3d& line);

}  // namespace plumbline::ifc

#include "building/ifc/facade_lines.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace plumbline::ifc {
namespace {

const double kAlike = std::cos(20 * std::numbers::pi / 180);
/// A box is a panel or a wall if its thinnest side is at most half of the next.
constexpr double kThin = 0.5;

}  // namespace

bool alike(const Eigen::Vector3d& a, const Eigen::Vector3d& b) { return std::abs(a.dot(b)) > kAlike; }

bool same_way(const Eigen::Vector3d& a, const Eigen::Vector3d& b) { return a.dot(b) >= kAlike; }

Eigen::Matrix3d axes_of(const Element& element) { return element.project_from_element.rotation.toRotationMatrix(); }

std::optional<Eigen::Vector3d> own_direction(const Element& element) {
  const Eigen::Matrix3d axes = axes_of(element);
  if (axes(2, 2) < 0.7) return {};
  return Eigen::Vector3d(-axes.col(1));
}

std::optional<int> thin_axis(const Element& element) {
  if (!element.has_box) return {};
  const Eigen::Vector3d size = element.box_high - element.box_low;
  int thin = 0;
  size.minCoeff(&thin);
  const double next = std::min(size[(thin + 1) % 3], size[(thin + 2) % 3]);
  if (!(size[thin] <= kThin * next)) return {};
  return thin;
}

Eigen::Vector3d middle_of(const Element& element) {
  return element.project_from_element * Eigen::Vector3d(0.5 * (element.box_low + element.box_high));
}

std::optional<FacadeLine> line_of_host(const Element& host, const Eigen::Vector3d& anchor) {
  if (!host.has_box) return {};
  const Eigen::Matrix3d axes = axes_of(host);
  const Eigen::Vector3d own = host.project_from_element.inverse() * anchor;
  std::optional<FacadeLine> best;
  double nearest = kAtFace, second = 1e300;
  for (int axis = 0; axis < 3; ++axis) {
    if (std::abs(axes(2, axis)) > 0.7) continue;  // top and bottom
    for (const double sign : {-1.0, 1.0}) {
      const double distance = std::abs(own[axis] - (sign > 0 ? host.box_high : host.box_low)[axis]);
      if (distance < nearest)
        second = best ? nearest : second, nearest = distance, best = FacadeLine{sign * axes.col(axis), true};
      else
        second = std::min(second, distance);
    }
  }
  // At a corner, or in the middle of a thin wall, the nearest face says nothing.
  if (best && second < nearest + 0.05) best->outward = false;
  if (best && second < nearest + 0.05 && thin_axis(host) && std::abs(axes(2, *thin_axis(host))) < 0.7)
    best->direction = axes.col(*thin_axis(host));
  else if (best && second < nearest + 0.05)
    return {};
  return best;
}

bool carries(const Element& element) {
  const std::string& name = element.ifc_class;
  return !element.is_anchor && !element.is_panel && element.has_box &&
         (name.starts_with("IfcSlab") || name.starts_with("IfcWall") || name.starts_with("IfcColumn") ||
          name.starts_with("IfcBeam"));
}

int side_of_edges(const std::vector<FacadeLine>& edges, const Eigen::Vector3d& line) {
  int side = 0;
  bool proven = false;
  for (const FacadeLine& edge : edges) {
    if (!alike(edge.direction, line)) continue;
    const int one = edge.direction.dot(line) < 0 ? -1 : 1;
    if (side == -one) return 0;
    side = one, proven = proven || !edge.may_hang;
  }
  return proven ? side : 0;
}

}  // namespace plumbline::ifc

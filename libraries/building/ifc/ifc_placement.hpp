// Placements of an IFC file as rigid transforms. Lengths are in the file's unit, so that nothing is rounded on the way;
// the reader of the design converts once, at the end.
#pragma once

#include <limits>
#include <unordered_map>

#include "building/ifc/ifc_model.hpp"
#include "plumbline/rigid_transform.hpp"

namespace plumbline::ifc {

/// A point of two or three coordinates; z = 0 for two. Throws step::Error.
Eigen::Vector3d read_point(const Model& model, std::uint64_t id, std::uint64_t referrer);
/// A direction, normalised; z = 0 for two ratios. Throws step::Error for one without length.
Eigen::Vector3d read_direction(const Model& model, std::uint64_t id, std::uint64_t referrer);
/// IfcAxis2Placement2D or 3D: maps coordinates inside it to those around it. Identity for nothing.
RigidTransform read_axis_placement(const Model& model, std::optional<std::uint64_t> id, std::uint64_t referrer);

/// A line in the plane of a grid, lengths in the file's unit.
struct PlacementLine {
  Eigen::Vector3d point, direction;
  double begin = -std::numeric_limits<double>::infinity(),
         end = std::numeric_limits<double>::infinity();  ///< from `point` along `direction`
};
/// An IfcGridAxis in its sense, in the axes of its grid. Throws step::Error for one that is not straight.
PlacementLine read_grid_axis(const Model& model, const Entity& axis);

/// Object placements, each resolved once.
class Placements {
 public:
  explicit Placements(const Model& model) : model_(model) {}

  /// project_from_object of an IfcObjectPlacement. Throws step::Error for a cycle, and for a kind we do not read
  /// (linear placement without its Cartesian fallback, grid axes that are not straight).
  RigidTransform project_from_placement(std::uint64_t id, std::uint64_t referrer);

 private:
  RigidTransform resolve(std::uint64_t id, std::uint64_t referrer, int depth);
  RigidTransform grid_placement(const Entity& placement, int depth);

  const Model& model_;
  std::unordered_map<std::uint64_t, RigidTransform> known_;
};

}  // namespace plumbline::ifc

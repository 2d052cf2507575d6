#include "building/ifc/ifc_placement.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

namespace plumbline::ifc {
namespace {

/// Longer chains occur in no building; a cycle is one without end.
constexpr int kLongestChain = 200;

Eigen::Vector3d two_or_three(const Entity& entity, std::string_view attribute) {
  const std::vector<double> ratios = entity.numbers(attribute);
  if (ratios.size() < 2 || ratios.size() > 3) entity.fail(attribute, "two or three numbers");
  return {ratios[0], ratios[1], ratios.size() == 3 ? ratios[2] : 0};
}

/// Rotation whose z is `axis` and whose x is `reference` made perpendicular to it (IfcBuildAxes).
Eigen::Matrix3d axes(const Eigen::Vector3d& axis, const Eigen::Vector3d& reference) {
  Eigen::Vector3d x = reference - axis * axis.dot(reference);
  if (x.norm() < 1e-9) {  // parallel: the standard's own fallback
    const Eigen::Vector3d other = std::abs(axis.x()) < 0.9 ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitY();
    x = other - axis * axis.dot(other);
  }
  x.normalize();
  Eigen::Matrix3d rotation;
  rotation << x, axis.cross(x), axis;
  return rotation;
}

Eigen::Vector3d intersection(const Model& model, const Entity& crossing, Eigen::Vector3d* tangent) {
  const auto ids = crossing.references("IntersectingAxes");
  std::vector<double> offsets = crossing.numbers("OffsetDistances");
  offsets.resize(std::max<std::size_t>(offsets.size(), 3), 0.0);
  if (ids.size() != 2) crossing.fail("IntersectingAxes", "two axes");
  PlacementLine lines[2];
  for (std::size_t i = 0; i < 2; ++i) {
    lines[i] = read_grid_axis(model, model.entity(ids[i], crossing.id()));
    // Positive offsets lie to the left of the axis, as with IfcOffsetCurve2D.
    lines[i].point += offsets[i] * Eigen::Vector3d::UnitZ().cross(lines[i].direction);
  }
  const double sine = lines[0].direction.cross(lines[1].direction).z();
  if (std::abs(sine) < 1e-9) crossing.fail("IntersectingAxes", "two axes that cross");
  const double along = (lines[1].point - lines[0].point).cross(lines[1].direction).z() / sine;
  if (tangent) *tangent = lines[0].direction;
  Eigen::Vector3d point = lines[0].point + along * lines[0].direction;
  point.z() += offsets[2];
  return point;
}

/// Placement of the IfcGrid that owns an axis, if the file has one.
std::optional<std::uint64_t> placement_of_grid(const Model& model, std::uint64_t axis) {
  for (const Entity& grid : model.all("IFCGRID"))
    for (const char* attribute : {"UAxes", "VAxes", "WAxes"}) {
      const auto axes = grid.references(attribute);
      if (std::find(axes.begin(), axes.end(), axis) != axes.end()) return grid.optional_reference("ObjectPlacement");
    }
  return {};
}

}  // namespace

PlacementLine read_grid_axis(const Model& model, const Entity& axis) {
  const Entity curve = model.entity(axis.reference("AxisCurve"), axis.id());
  PlacementLine line;
  if (curve.keyword() == "IFCLINE") {
    line.point = read_point(model, curve.reference("Pnt"), curve.id());
    const Entity vector = model.entity(curve.reference("Dir"), curve.id());
    line.direction = read_direction(model, vector.reference("Orientation"), vector.id());
  } else if (curve.keyword() == "IFCPOLYLINE" && curve.references("Points").size() == 2) {
    const auto points = curve.references("Points");
    line.point = read_point(model, points[0], curve.id());
    const Eigen::Vector3d along = read_point(model, points[1], curve.id()) - line.point;
    line.direction = along.normalized(), line.begin = 0, line.end = along.norm();
  } else {
    axis.fail("AxisCurve", "a straight line; " + curve.keyword() + " is not read");
  }
  if (axis.value("SameSense").text == "F")
    line.direction = -line.direction, std::tie(line.begin, line.end) = std::pair(-line.end, -line.begin);
  return line;
}

Eigen::Vector3d read_point(const Model& model, std::uint64_t id, std::uint64_t referrer) {
  const Entity point = model.entity(id, referrer);
  return two_or_three(point, "Coordinates");
}

Eigen::Vector3d read_direction(const Model& model, std::uint64_t id, std::uint64_t referrer) {
  const Entity direction = model.entity(id, referrer);
  const Eigen::Vector3d ratios = two_or_three(direction, "DirectionRatios");
  // Scaled first: ratios like 1e-200 have a direction but no squared length.
  const double largest = ratios.cwiseAbs().maxCoeff();
  if (!(largest > 0) || !std::isfinite(largest)) direction.fail("DirectionRatios", "a direction with a length");
  return (ratios / largest).normalized();
}

RigidTransform read_axis_placement(const Model& model, std::optional<std::uint64_t> id, std::uint64_t referrer) {
  if (!id) return {};
  const Entity placement = model.entity(*id, referrer);
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ(), reference = Eigen::Vector3d::UnitX();
  if (placement.keyword() == "IFCAXIS2PLACEMENT3D") {
    if (const auto given = placement.optional_reference("Axis")) axis = read_direction(model, *given, *id);
  } else if (placement.keyword() != "IFCAXIS2PLACEMENT2D") {
    placement.fail("Location", "an IfcAxis2Placement2D or 3D");
  }
  if (const auto given = placement.optional_reference("RefDirection")) reference = read_direction(model, *given, *id);
  return {Eigen::Quaterniond(axes(axis, reference)).normalized(),
          read_point(model, placement.reference("Location"), *id)};
}

RigidTransform Placements::project_from_placement(std::uint64_t id, std::uint64_t referrer) {
  return resolve(id, referrer, 0);
}

RigidTransform Placements::resolve(std::uint64_t id, std::uint64_t referrer, int depth) {
  if (const auto known = known_.find(id); known != known_.end()) return known->second;
  const Entity placement = model_.entity(id, referrer);
  if (depth > kLongestChain)
    placement.fail("PlacementRelTo", "a chain of at most " + std::to_string(kLongestChain) +
                                         " placements; this one is longer or is a cycle");
  RigidTransform own;
  std::optional<std::uint64_t> parent;
  if (placement.keyword() == "IFCGRIDPLACEMENT") {
    own = grid_placement(placement, depth);
  } else {
    parent = placement.optional_reference("PlacementRelTo");
    if (placement.keyword() == "IFCLINEARPLACEMENT") {
      own = read_axis_placement(model_, placement.reference("CartesianPosition"), id);
    } else {
      own = read_axis_placement(model_, placement.reference("RelativePlacement"), id);
    }
  }
  const RigidTransform result = parent ? resolve(*parent, id, depth + 1) * own : own;
  if (!result.translation.allFinite() || !result.rotation.coeffs().allFinite())
    placement.fail("PlacementRelTo", "coordinates within the range of double precision");
  known_[id] = result;
  return result;
}

RigidTransform Placements::grid_placement(const Entity& placement, int depth) {
  const Entity crossing = model_.entity(placement.reference("PlacementLocation"), placement.id());
  Eigen::Vector3d direction = Eigen::Vector3d::UnitX();
  const Eigen::Vector3d origin = intersection(model_, crossing, &direction);
  if (const auto reference = placement.optional_reference("PlacementRefDirection")) {
    if (model_.keyword(*reference) == "IFCDIRECTION")
      direction = read_direction(model_, *reference, placement.id());
    else
      direction = (intersection(model_, model_.entity(*reference, placement.id()), nullptr) - origin).normalized();
  }
  const RigidTransform in_grid{Eigen::Quaterniond(axes(Eigen::Vector3d::UnitZ(), direction)).normalized(), origin};
  // Since IFC4X3 the placement names its parent itself; before, it is that of the grid.
  std::optional<std::uint64_t> parent;
  if (model_.schema() == Schema::ifc4x3) parent = placement.optional_reference("PlacementRelTo");
  if (!parent) parent = placement_of_grid(model_, crossing.references("IntersectingAxes")[0]);
  return parent ? resolve(*parent, placement.id(), depth + 1) * in_grid : in_grid;
}

}  // namespace plumbline::ifc

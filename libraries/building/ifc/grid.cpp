#include "building/ifc/grid.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "artifacts/design.hpp"

namespace plumbline::ifc {
namespace {

/// Two axes of one tag that lie closer than this are one [m].
constexpr double kSame = 1e-3;
const double kAcross = std::cos(20 * std::numbers::pi / 180);

/// Where a point lies along an axis, and how far beside it.
Eigen::Vector2d along_and_beside(const GridAxis& axis, const Eigen::Vector3d& point) {
  const Eigen::Vector2d d = (point - axis.point).head<2>(), along = axis.direction.head<2>().normalized();
  return {d.dot(along), std::abs(d.x() * along.y() - d.y() * along.x())};
}

bool same(const GridAxis& a, const GridAxis& b) {
  return a.tag == b.tag && std::abs(a.direction.dot(b.direction)) > 1 - 1e-9 &&
         along_and_beside(a, b.point).y() < kSame;
}

/// Drawn once for each storey, an axis is as long as all its drawings.
void lengthen(GridAxis& axis, const GridAxis& by) {
  const double from = along_and_beside(axis, by.point).x(), sign = axis.direction.dot(by.direction) < 0 ? -1 : 1;
  const double one = from + sign * by.begin, other = from + sign * by.end;
  axis.begin = std::min({axis.begin, one, other}), axis.end = std::max({axis.end, one, other});
}

}  // namespace

std::vector<GridAxis> read_grid(const Model& model, Placements& placements, double length_unit,
                                std::vector<std::string>& warnings) {
  std::vector<GridAxis> all;
  int left_out = 0;
  std::string first;
  const auto read = [&](const Entity& grid, const RigidTransform& placement, const char* list, std::uint64_t id) {
    try {
      const Entity axis = model.entity(id, grid.id());
      const PlacementLine line = read_grid_axis(model, axis);
      GridAxis found{axis.text("AxisTag"),
                     std::string(1, static_cast<char>(list[0] + 32)),
                     length_unit * (placement * line.point),
                     placement.rotation * line.direction,
                     length_unit * line.begin,
                     length_unit * line.end};
      if (found.tag.empty()) axis.fail("AxisTag", "a tag");
      const auto known =
          std::find_if(all.begin(), all.end(), [&](const GridAxis& other) { return same(other, found); });
      if (known == all.end())
        all.push_back(std::move(found));
      else
        lengthen(*known, found);
    } catch (const step::Error& error) {
      if (++left_out == 1) first = error.what();
    }
  };
  for (const std::uint32_t index : model.file().of_type("IFCGRID")) {
    try {
      const Entity grid = model.entity(model.file().instances()[index]);
      const auto id = grid.optional_reference("ObjectPlacement");
      const RigidTransform placement = id ? placements.project_from_placement(*id, grid.id()) : RigidTransform();
      for (const char* list : {"UAxes", "VAxes", "WAxes"}) {
        if (grid.value(list).kind != step::Kind::list) continue;  // W is optional
        for (const std::uint64_t axis : grid.references(list)) read(grid, placement, list, axis);
      }
    } catch (const step::Error& error) {
      if (++left_out == 1) first = error.what();
    }
  }
  if (left_out > 0)
    warnings.push_back(std::to_string(left_out) + " axes or grids (IfcGrid) were left out; the first: " + first);
  return all;
}

std::vector<GridAxis> grid_of(const DesignT& design) {
  std::vector<GridAxis> all;
  for (const auto& axis : design.grid_axes) {
    GridAxis& to = all.emplace_back(GridAxis{axis->tag, axis->family, axis->point, axis->direction});
    if (std::isfinite(axis->begin) && std::isfinite(axis->end)) to.begin = axis->begin, to.end = axis->end;
  }
  return all;
}

double distance_to(const GridAxis& axis, const Eigen::Vector3d& point) {
  constexpr double kBeyond = 5;  // [m], what a facade stands out beyond the drawn axes
  const Eigen::Vector2d at = along_and_beside(axis, point);
  return std::hypot(std::max({0.0, axis.begin - kBeyond - at.x(), at.x() - axis.end - kBeyond}), at.y());
}

const GridAxis* axis_across(const std::vector<GridAxis>& grid, const Eigen::Vector3d& point,
                            const Eigen::Vector3d& out) {
  const GridAxis* nearest = nullptr;
  if (!out.allFinite() || out.head<2>().norm() < 0.7) return nullptr;
  for (const GridAxis& axis : grid)
    if (std::abs(axis.direction.head<2>().normalized().dot(out.head<2>().normalized())) >= kAcross &&
        (!nearest || distance_to(axis, point) < distance_to(*nearest, point)))
      nearest = &axis;
  return nearest;
}

std::string grid_place(const std::vector<GridAxis>& grid, const Eigen::Vector3d& point) {
  const auto nearest = [&](const char* family) {
    const GridAxis* best = nullptr;
    for (const GridAxis& axis : grid)
      if (axis.family == family && (!best || distance_to(axis, point) < distance_to(*best, point))) best = &axis;
    return best;
  };
  const GridAxis *u = nearest("u"), *v = nearest("v");
  return u && v ? u->tag + "/" + v->tag : std::string();
}

}  // namespace plumbline::ifc

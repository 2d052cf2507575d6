#include "show/report/building_lines.hpp"

#include <algorithm>
#include <cmath>

namespace plumbline::report {

namespace {

/// Farther than this beyond the anchors nobody looks for an axis [m].
constexpr double kBeyond = 2;

}  // namespace

BuildingLines building_lines(const DesignT& design, std::size_t most) {
  BuildingLines lines;
  lines.true_north = design.true_north;
  std::vector<std::pair<double, const DesignElementT*>> large;  // by the longest diagonal
  for (const auto& element : design.elements)
    if (!element->is_anchor && !element->is_panel && element->box_low.allFinite() && element->box_high.allFinite() &&
        element->object_type != "AsBuiltAnchor" && element->object_type != "AsBuiltPanel")
      large.emplace_back((element->box_high - element->box_low).norm(), element.get());
  std::stable_sort(large.begin(), large.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  if (large.size() > most) large.resize(most);
  for (const auto& [size, element] : large) {
    const auto corner = [&, e = element](int k) {
      const Eigen::Vector3d own(k & 1 ? e->box_high.x() : e->box_low.x(), k & 2 ? e->box_high.y() : e->box_low.y(),
                                k & 4 ? e->box_high.z() : e->box_low.z());
      return Eigen::Vector3d(e->placement * own);
    };
    for (int k = 0; k < 8; ++k)
      for (const int axis : {1, 2, 4})
        if (!(k & axis)) lines.edges.emplace_back(corner(k), corner(k | axis));
  }
  return lines;
}

std::vector<std::pair<Eigen::Vector3d, Eigen::Vector3d>> grid_lines(const std::vector<ifc::GridAxis>& grid,
                                                                    const Eigen::Vector3d& low,
                                                                    const Eigen::Vector3d& high) {
  const Eigen::Vector3d middle = 0.5 * (low + high);
  const double half = 0.5 * (high - low).head<2>().norm() + kBeyond;
  std::vector<std::pair<Eigen::Vector3d, Eigen::Vector3d>> lines;
  for (const ifc::GridAxis& axis : grid) {
    Eigen::Vector3d along = axis.direction;
    along.z() = 0;
    along.normalize();
    Eigen::Vector3d at = axis.point + along * along.dot(middle - axis.point);
    at.z() = low.z();
    lines.emplace_back(at - half * along, at + half * along);
  }
  return lines;
}

}  // namespace plumbline::report

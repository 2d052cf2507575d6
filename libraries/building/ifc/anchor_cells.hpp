// The anchors of a design by place, for questions of the kind "which are near this element".
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <vector>

#include "building/ifc/design.hpp"
#include "building/ifc/facade_lines.hpp"

namespace plumbline::ifc {

/// Points to the anchors of `design`, which must stay where they are.
class AnchorCells {
 public:
  explicit AnchorCells(Design& design) {
    for (Element& element : design.elements)
      if (element.is_anchor) cells_[cell_of(element.position)].push_back(&element);
  }

  /// All anchors that may be within `reach` [m] of the element's box, with the way from the box to them (project frame,
  /// zero inside). The element must have a box.
  template <class Visit>
  void for_anchors_at(const Element& element, double reach, const Visit& visit) const {
    const RigidTransform own = element.project_from_element.inverse();
    const Eigen::Vector3d half = axes_of(element).cwiseAbs() * (0.5 * (element.box_high - element.box_low));
    const Cell low = cell_of(middle_of(element) - half - Eigen::Vector3d::Constant(reach)),
               high = cell_of(middle_of(element) + half + Eigen::Vector3d::Constant(reach));
    for (auto it = cells_.lower_bound({low[0], low[1], low[2]}); it != cells_.end() && it->first[0] <= high[0]; ++it) {
      const Cell& cell = it->first;
      if (cell[1] < low[1] || cell[1] > high[1] || cell[2] < low[2] || cell[2] > high[2]) continue;
      for (Element* anchor : it->second) {
        const Eigen::Vector3d at = own * anchor->position;
        visit(*anchor, axes_of(element) * (at - at.cwiseMax(element.box_low).cwiseMin(element.box_high)));
      }
    }
  }

 private:
  using Cell = std::array<int, 3>;
  static Cell cell_of(const Eigen::Vector3d& p) {
    const auto index = [&](int k) { return static_cast<int>(std::floor(std::clamp(p[k], -1e8, 1e8) / 4)); };
    return {index(0), index(1), index(2)};
  }

  std::map<Cell, std::vector<Element*>> cells_;
};

}  // namespace plumbline::ifc

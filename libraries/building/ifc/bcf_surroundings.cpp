#include "building/ifc/bcf_surroundings.hpp"

#include <algorithm>
#include <cmath>
#include <set>

namespace plumbline::ifc {
namespace {

constexpr double kCell = 5;  ///< [m] half a panel of a facade is smaller

int cell_at(double value) { return static_cast<int>(std::floor(std::clamp(value, -1e8, 1e8) / kCell)); }

}  // namespace

template <class T>
void BcfSurroundings::Index<T>::add(const T& item, const Eigen::Vector3d& centre, double reach) {
  if (!centre.allFinite() || !std::isfinite(reach)) return;
  if (reach > kCell)
    large.push_back(all.size());
  else
    cells[{cell_at(centre.x()), cell_at(centre.y()), cell_at(centre.z())}].push_back(all.size());
  all.push_back(&item);
}

template <class T>
std::vector<const T*> BcfSurroundings::Index<T>::near(const Eigen::Vector3d& centre, double radius) const {
  std::vector<std::size_t> found = large;
  const double reach = radius + kCell;
  const auto low = [&](int k) { return cell_at(centre[k] - reach); };
  const auto high = [&](int k) { return cell_at(centre[k] + reach); };
  // Around what reaches far there are fewer cells with something in them than without.
  const double columns = (1.0 + high(0) - low(0)) * (1.0 + high(1) - low(1));
  if (!(columns <= static_cast<double>(cells.size()))) {
    for (const auto& [cell, items] : cells)
      if (cell[0] >= low(0) && cell[0] <= high(0) && cell[1] >= low(1) && cell[1] <= high(1) && cell[2] >= low(2) &&
          cell[2] <= high(2))
        found.insert(found.end(), items.begin(), items.end());
  } else
    for (int x = low(0); x <= high(0); ++x)
      for (int y = low(1); y <= high(1); ++y)
        for (auto it = cells.lower_bound({x, y, low(2)}); it != cells.end() && it->first <= Cell{x, y, high(2)}; ++it)
          found.insert(found.end(), it->second.begin(), it->second.end());
  std::sort(found.begin(), found.end());
  std::vector<const T*> items;
  for (const std::size_t i : found) items.push_back(all[i]);
  return items;
}

BcfSurroundings::BcfSurroundings(const DeviationT& deviation, const std::vector<Element>* elements) {
  for (const auto& anchor : deviation.anchors) anchors_.add(*anchor, anchor->design, 0);
  for (const auto& panel : deviation.panels) {
    if (panel->corners.empty()) continue;
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    for (const auto& corner : panel->corners) centre += corner->design / static_cast<double>(panel->corners.size());
    double reach = 0;
    for (const auto& corner : panel->corners) reach = std::max(reach, (corner->design - centre).norm());
    panels_.add(*panel, centre, reach);
  }
  if (!elements) return;
  std::set<std::string> wholes;
  for (const Element& element : *elements)
    if (element.has_box) wholes.insert(element.parent_guid);
  for (const Element& element : *elements) {
    if (!element.has_box || wholes.contains(element.guid)) continue;
    if (element.ifc_class.starts_with("IfcOpening") || element.ifc_class.starts_with("IfcVirtual")) continue;
    const Eigen::Vector3d middle = 0.5 * (element.box_low + element.box_high);
    shapes_.add(element, element.project_from_element * middle, (element.box_high - middle).norm());
  }
}

BcfSurroundings::Around BcfSurroundings::around(const Eigen::Vector3d& centre, double radius) const {
  return {anchors_.near(centre, radius), panels_.near(centre, radius), shapes_.near(centre, radius)};
}

}  // namespace plumbline::ifc

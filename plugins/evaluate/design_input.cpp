#include "evaluate/design_input.hpp"

#include <map>
#include <set>

#include "geometry/panel_fit.hpp"

namespace plumbline::evaluate {

PointSet design_points(const DesignT& design, const std::function<void(const std::string&)>& warn) {
  std::map<std::string, std::vector<const DesignElementT*>> by_name;
  for (const auto& element : design.elements)
    if (element->is_anchor && !element->name.empty()) by_name[element->name].push_back(element.get());
  PointSet set;
  for (const auto& [name, elements] : by_name) {
    if (elements.size() > 1) {
      warn("input 'design': " + std::to_string(elements.size()) + " anchors are named '" + name +
           "'; they are not compared with the design");
      continue;
    }
    set.ids.push_back(name);
    set.positions.push_back(elements.front()->position);
  }
  return set;
}

std::vector<PanelEntry> design_panels(const DesignT& design, const PointSet& points) {
  if (!design.facade_normal.allFinite()) return {};
  std::map<std::string, std::string> name_of_guid;
  std::set<std::string> wholes;
  for (const auto& element : design.elements) {
    if (element->is_anchor) name_of_guid[element->guid] = element->name;
    if (element->is_panel) wholes.insert(element->parent_guid);
  }
  std::vector<PanelEntry> panels;
  for (const auto& element : design.elements) {
    if (!element->is_panel || wholes.count(element->guid) || !element->box_low.allFinite()) continue;
    PanelEntry panel;
    panel.guid = element->guid, panel.name = element->name;
    panel.centre = element->placement * Eigen::Vector3d(0.5 * (element->box_low + element->box_high));
    panel.outward = design.facade_normal;
    const std::set<std::string> said(element->anchor_guids.begin(), element->anchor_guids.end());
    std::set<std::string> names;
    for (const std::string& guid : said)
      if (const auto found = name_of_guid.find(guid); found != name_of_guid.end()) names.insert(found->second);
    const RigidTransform panel_from_project = element->placement.inverse();
    for (std::size_t i = 0; i < points.ids.size(); ++i) {
      const bool holds = said.empty() ? distance_from_box(element->box_low, element->box_high,
                                                          panel_from_project * points.positions[i]) <= kPanelReach
                                      : names.count(points.ids[i]) > 0;
      if (holds) panel.anchors.push_back(points.ids[i]);
    }
    if (!panel.anchors.empty()) panels.push_back(std::move(panel));
  }
  return panels;
}

}  // namespace plumbline::evaluate

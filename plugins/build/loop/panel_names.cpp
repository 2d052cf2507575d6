#include "build/loop/panel_names.hpp"

#include <algorithm>
#include <limits>

namespace plumbline::loop {
namespace {

/// Of a panel with this GlobalId in the state of the round before; empty: there is none.
std::string id_in_state(const LoopStateT* state, const std::string& guid) {
  if (state)
    for (const auto& item : state->items)
      if (item->kind == "panel" && item->guid == guid) return item->id;
  return {};
}

/// "Panel at F1-C1-R1"; empty where no anchor of it has a place.
std::string name_by_anchor(const DeviationT& deviation, const PanelDeviationT& panel) {
  const auto corner = std::find_if(panel.corners.begin(), panel.corners.end(),
                                   [](const auto& one) { return one->name == "bottom_left"; });
  if (corner == panel.corners.end()) return {};
  std::string nearest;
  double least = std::numeric_limits<double>::infinity();
  const std::vector<std::string> own = anchors_of(panel);
  for (const auto& anchor : deviation.anchors)
    if (const double off = (anchor->design - (*corner)->design).norm();
        off < least && std::find(own.begin(), own.end(), anchor->id) != own.end())
      least = off, nearest = anchor->id;
  if (nearest.empty()) return {};
  return (panel.name.empty() ? std::string("panel") : panel.name) + " at " + nearest;
}

}  // namespace

std::map<std::string, std::string> names_of_panels(const DeviationT& deviation, const DesignElements& elements,
                                                   const LoopStateT* state) {
  std::map<std::string, int> named, tagged;
  for (const auto& panel : deviation.panels) ++named[panel->name], ++tagged[elements.tag_of(panel->guid)];
  std::map<std::string, int> taken;
  std::map<std::string, std::string> id_of;
  for (const auto& panel : deviation.panels) {
    std::string id = named[panel->name] == 1 ? panel->name : id_in_state(state, panel->guid);
    if (id.empty() && tagged[elements.tag_of(panel->guid)] == 1) id = elements.tag_of(panel->guid);
    if (id.empty()) id = name_by_anchor(deviation, *panel);
    ++taken[id_of[panel->guid] = id];
  }
  for (auto& [guid, id] : id_of)
    if (id.empty() || taken[id] > 1) id = guid;
  return id_of;
}

std::string name_of_unplanned(const DesignElementT& element, const DesignElements& elements, const LoopStateT* state,
                              const std::vector<Panel>& planned) {
  if (const std::string known = id_in_state(state, element.guid); !known.empty()) return known;
  const bool is_taken =
      std::any_of(planned.begin(), planned.end(), [&](const Panel& panel) { return panel.id == element.name; }) ||
      std::any_of(elements.by_guid.begin(), elements.by_guid.end(), [&](const auto& other) {
        return other.first != element.guid && other.second->name == element.name && elements.is_panel(*other.second);
      });
  return element.name.empty() || is_taken ? element.guid : element.name;
}

std::vector<std::string> anchors_of(const PanelDeviationT& judged) {
  std::vector<std::string> ids;
  for (const auto& fixing : judged.fixings) ids.push_back(fixing->anchor);
  ids.insert(ids.end(), judged.missing.begin(), judged.missing.end());
  return ids;
}

}  // namespace plumbline::loop

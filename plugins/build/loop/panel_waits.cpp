#include "build/loop/panel_waits.hpp"

#include <algorithm>
#include <stdexcept>

#include "base/text/words.hpp"
#include "build/loop/panel_names.hpp"
#include "build/loop/panel_order.hpp"

namespace plumbline::loop {
namespace {

std::string trimmed(const std::string& text) {
  const auto from = text.find_first_not_of(" \t"), to = text.find_last_not_of(" \t");
  return from == std::string::npos ? std::string() : text.substr(from, to - from + 1);
}

/// Who hangs from the top downward says so, and no joint contradicts it.
bool is_said_to_come_after(const FacadeRules& rules, const std::string& panel, const std::string& other) {
  const auto rule = rules.after.find(panel);
  return rule != rules.after.end() && std::find(rule->second.begin(), rule->second.end(), other) != rule->second.end();
}

void check_standing(const FacadeRules& rules, const DesignElements& elements) {
  for (const std::string& name : rules.standing)
    if (name != "*" && std::none_of(elements.by_guid.begin(), elements.by_guid.end(), [&](const auto& element) {
          return elements.is_panel(*element.second) && element.second->name == name;
        }))
      throw std::runtime_error("'standing' names '" + name + "', which is no panel of the design");
}

bool is_said_to_stand(const FacadeRules& rules, const DesignElementT& panel) {
  return std::any_of(rules.standing.begin(), rules.standing.end(),
                     [&](const std::string& name) { return name == "*" || name == panel.name; });
}

/// Panels of the design with a place that are not planned.
std::vector<const DesignElementT*> unplanned_panels(const DesignElements& elements,
                                                    const std::map<std::string, std::size_t>& panel_at) {
  std::vector<const DesignElementT*> out;
  for (const auto& [guid, element] : elements.by_guid)
    if (elements.is_panel(*element) && panel_at.count(guid) == 0 && element->box_low.allFinite() &&
        element->box_high.allFinite())
      out.push_back(element);
  return out;
}

std::vector<Eigen::Vector3d> box_of(const DesignElementT& element) {
  std::vector<Eigen::Vector3d> corners;
  for (int corner = 0; corner < 8; ++corner)
    corners.push_back(element.placement * Eigen::Vector3d((corner & 1 ? element.box_high : element.box_low).x(),
                                                          (corner & 2 ? element.box_high : element.box_low).y(),
                                                          (corner & 4 ? element.box_high : element.box_low).z()));
  return corners;
}

}  // namespace

void depend(Panel& panel, const std::string& before) {
  if (std::find(panel.depends_on.begin(), panel.depends_on.end(), before) == panel.depends_on.end())
    panel.depends_on.push_back(before);
}

void wait_for_what_is_below(const FacadeRules& rules, const DesignElements& elements,
                            const std::map<std::string, std::size_t>& panel_at, const LoopStateT* state,
                            FacadeInput& in) {
  std::vector<PanelPlace> places;
  for (const Panel& panel : in.facade.panels)
    places.push_back({panel.id, {panel.corners.begin(), panel.corners.end()}});
  const std::size_t planned = places.size();
  check_standing(rules, elements);
  const std::vector<const DesignElementT*> unplanned = unplanned_panels(elements, panel_at);
  for (const DesignElementT* element : unplanned)
    places.push_back({name_of_unplanned(*element, elements, state, in.facade.panels), box_of(*element)});
  std::vector<std::vector<std::string>> above(unplanned.size());
  for (Panel& panel : in.facade.panels)
    for (const std::size_t below : next_below(panel, places)) {
      if (is_said_to_come_after(rules, places[below].id, panel.id) ||
          (below >= planned && is_said_to_stand(rules, *unplanned[below - planned])))
        continue;
      depend(panel, places[below].id);
      if (below >= planned) above[below - planned].push_back(panel.id);
    }
  for (std::size_t i = 0; i < unplanned.size(); ++i)
    if (!above[i].empty())
      in.notes.push_back("panel " + places[planned + i].id + " is not planned and is below " + text::join(above[i], 8) +
                         ": wait for it, unless a round before saw it hang or standing=['" + unplanned[i]->name +
                         "'] says that it does");
}

void add_dependence(const std::string& panel, const std::vector<std::string>& before, std::vector<Panel>& panels) {
  const auto find = [&](const std::string& id) {
    const auto at = std::find_if(panels.begin(), panels.end(), [&](const Panel& p) { return p.id == id; });
    if (at == panels.end())
      throw std::runtime_error("'after' names panel '" + id + "', which is none of the " +
                               std::to_string(panels.size()) + " panels with measured anchors");
    return at;
  };
  for (const std::string& id : before) find(panel)->depends_on.push_back(find(id)->id);
}

std::pair<std::string, std::vector<std::string>> parse_dependence(const std::string& text) {
  const auto word = text.find(" after ");
  std::pair<std::string, std::vector<std::string>> out;
  if (word != std::string::npos) {
    out.first = trimmed(text.substr(0, word));
    for (std::size_t from = word + 7; from <= text.size();) {
      const std::size_t comma = std::min(text.find(',', from), text.size());
      if (const std::string id = trimmed(text.substr(from, comma - from)); !id.empty()) out.second.push_back(id);
      from = comma + 1;
    }
  }
  if (out.first.empty() || out.second.empty())
    throw std::runtime_error("dependence '" + text + "': expected 'PANEL after PANEL, PANEL'");
  return out;
}

}  // namespace plumbline::loop

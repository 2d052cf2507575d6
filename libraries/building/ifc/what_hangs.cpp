#include "building/ifc/what_hangs.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <unordered_map>

#include "building/ifc/anchor_cells.hpp"
#include "geometry/panel_fit.hpp"

namespace plumbline::ifc {
namespace {

/// So many times its face is that of the panel that a fixing holds.
constexpr double kMuchLarger = 4;
/// Both sides of a panel's face are at least this [m]; mullions, brackets and rails are narrower.
constexpr double kSmallestPanel = 0.5;

using Held = std::unordered_map<const Element*, std::vector<Element*>>;

/// The anchors that hold each panel: those that the file ties to it, else those within reach.
Held anchors_of_panels(Design& design, const AnchorCells& cells) {
  std::unordered_map<std::string, Element*> by_guid;
  for (Element& element : design.elements)
    if (element.is_anchor) by_guid.try_emplace(element.guid, &element);
  Held held;
  for (Element& panel : design.elements) {
    if (!panel.is_panel) continue;
    for (const std::string& guid : panel.anchor_guids)
      if (const auto anchor = by_guid.find(guid); anchor != by_guid.end()) held[&panel].push_back(anchor->second);
    if (panel.anchor_guids.empty() && panel.has_box)
      cells.for_anchors_at(panel, kPanelReach, [&](Element& anchor, const Eigen::Vector3d& off) {
        if (off.norm() <= kPanelReach) held[&panel].push_back(&anchor);
      });
  }
  return held;
}

/// Sides of its box, ascending [m].
std::array<double, 3> sides_of(const Element& element) {
  const Eigen::Vector3d size = element.box_high - element.box_low;
  std::array<double, 3> sides = {size.x(), size.y(), size.z()};
  std::sort(sides.begin(), sides.end());
  return sides;
}

double face_of(const Element& element) {
  const auto sides = sides_of(element);
  return sides[1] * sides[2];
}

std::string some(const std::vector<std::string>& names) {
  return "'" + names.front() + "'" + (names.size() > 1 ? " and " + std::to_string(names.size() - 1) + " more" : "");
}

std::string name_or_guid(const Element& element) { return element.name.empty() ? element.guid : element.name; }

/// The value of panel_selection for these classes.
std::string selecting(const std::set<std::string>& classes) {
  std::string text;
  for (const std::string& one : classes) text += (text.empty() ? "'class=" : ", 'class=") + one + "'";
  return text;
}

bool is_flat_and_upright(const Element& element) {
  const auto thin = thin_axis(element);
  return thin && sides_of(element)[1] >= kSmallestPanel && std::abs(axes_of(element)(2, *thin)) < 0.7;
}

}  // namespace

bool is_fixing_plate(const std::string& kind) {
  static const std::set<std::string> kinds = {"BASE_PLATE",   "FLANGE_PLATE",    "GUSSET_PLATE",
                                              "SPLICE_PLATE", "STIFFENER_PLATE", "WEB_PLATE"};
  return kinds.contains(kind);
}

std::set<const Element*> bare_anchors(Design& design) {
  std::set<const Element*> bare;
  for (const Element& element : design.elements)
    if (element.is_anchor) bare.insert(&element);
  if (bare.empty()) return bare;
  const std::set<const Element*> fixings = may_be_fixings(design);
  for (const auto& [panel, anchors] : anchors_of_panels(design, AnchorCells(design))) {
    if (fixings.contains(panel)) continue;  // whose real panel may be what is called otherwise
    for (const Element* anchor : anchors) bare.erase(anchor);
  }
  return bare;
}

void leave_out_fixing_plates(Design& design) {
  const std::set<const Element*> fixings = may_be_fixings(design);
  if (fixings.empty()) return;
  const Held held = anchors_of_panels(design, AnchorCells(design));
  std::unordered_map<const Element*, double> largest;  // face of what hangs at an anchor
  for (const auto& [panel, anchors] : held)
    for (const Element* anchor : anchors)
      if (panel->has_box) largest[anchor] = std::max(largest[anchor], face_of(*panel));
  std::vector<std::string> left_out;
  for (Element& plate : design.elements) {
    const auto anchors = fixings.contains(&plate) ? held.find(&plate) : held.end();
    if (anchors == held.end()) continue;
    if (!std::all_of(anchors->second.begin(), anchors->second.end(),
                     [&](const Element* anchor) { return largest[anchor] >= kMuchLarger * face_of(plate); }))
      continue;
    plate.is_panel = false;
    left_out.push_back(name_or_guid(plate));
  }
  if (left_out.empty()) return;
  design.warnings.push_back(std::to_string(left_out.size()) +
                            (left_out.size() > 1 ? " small plates (" : " small plate (") + some(left_out) +
                            ") at anchors that hold something much larger: parts of the fixing, judged as no panels. "
                            "If they are panels, name "
                            "all panels, such as design.with.panel_selection=['class=IfcPlate']");
}

bool may_hang(const std::string& ifc_class) {
  static const std::set<std::string> classes = {
      "IfcWindow", "IfcWindowStandardCase", "IfcDoor", "IfcDoorStandardCase", "IfcBuildingElementProxy",
      "IfcElementAssembly", "IfcBuildingElementPart", "IfcMember", "IfcMemberStandardCase", "IfcShadingDevice",
      // Upright slabs are what some programs make of precast parts, and roofs of fields of cladding.
      "IfcSlab", "IfcSlabStandardCase", "IfcSlabElementedCase", "IfcRoof", "IfcRailing", "IfcFurnishingElement"};
  return classes.contains(ifc_class);
}

void tell_what_hangs(Design& design, const std::function<void(Element&)>& read,
                     const std::function<bool(std::uint64_t)>& fills) {
  const std::set<const Element*> bare = bare_anchors(design);
  if (bare.empty()) return;
  const AnchorCells cells(design);
  std::set<std::string> panel_classes, hosts;
  for (const auto& [panel, anchors] : anchors_of_panels(design, cells)) panel_classes.insert(panel->ifc_class);
  for (const Element* anchor : bare) hosts.insert(anchor->host_guid);
  std::map<std::string, std::vector<std::string>> hanging;  // names, by class
  for (Element& element : design.elements) {
    if (element.is_anchor || element.is_panel || !may_hang(element.ifc_class) || hosts.contains(element.guid) ||
        element.object_type == "AsBuiltPanel" || element.object_type == "AsBuiltAnchor" || fills(element.instance))
      continue;
    if (!element.has_box) read(element);
    if (!element.has_box || !is_flat_and_upright(element)) continue;
    bool at_bare = false;
    cells.for_anchors_at(element, kPanelReach, [&](const Element& anchor, const Eigen::Vector3d& off) {
      at_bare = at_bare || (off.norm() <= kPanelReach && bare.contains(&anchor));
    });
    if (at_bare) hanging[element.ifc_class].push_back(name_or_guid(element));
  }
  for (const auto& [ifc_class, names] : hanging) {
    std::set<std::string> all = panel_classes;
    all.insert(ifc_class);
    design.not_applied.push_back({ifc_class + " at anchors (" + some(names) + ")", "design",
                                  "whether they are panels is not known: they hang at anchors that hold no panel. Say "
                                  "which elements are panels, "
                                  "all of them, with \"design.with.panel_selection=[" +
                                      selecting(all) +
                                      "]\", or that these are none with \"design.with.panel_selection=[" +
                                      (panel_classes.empty() ? "none" : selecting(panel_classes)) + "]\""});
  }
}

}  // namespace plumbline::ifc

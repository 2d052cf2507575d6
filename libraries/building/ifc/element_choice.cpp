#include "building/ifc/element_choice.hpp"

#include <algorithm>

#include "building/ifc/what_hangs.hpp"

namespace plumbline::ifc {
namespace {

bool clads(const std::string& ifc_class, const std::string& kind) {
  return ifc_class == "IfcCurtainWall" || (ifc_class == "IfcCovering" && kind == "CLADDING") ||
         (ifc_class.starts_with("IfcPlate") && kind == "CURTAIN_PANEL");
}

/// Walls too, where they hang before their anchors (wall_panels.cpp).
bool may_be_panel(const std::string& ifc_class, const std::string& kind) {
  const bool plate = ifc_class == "IfcPlate" || ifc_class == "IfcPlateStandardCase";
  return clads(ifc_class, kind) || (plate && !is_fixing_plate(kind));
}

std::regex regular(const std::string& pattern) {
  try {
    return std::regex(pattern);
  } catch (const std::regex_error& error) {
    throw step::Error("anchor pattern '" + pattern + "' is no regular expression (ECMAScript): " + error.what());
  }
}

}  // namespace

std::string own_kind(const Entity& entity) {
  constexpr std::size_t predefined_type = 8;
  if (entity.arguments().size() <= predefined_type) return "";
  const step::Value& value = entity.arguments()[predefined_type];
  return value.kind == step::Kind::enumeration && value.text != "NOTDEFINED" ? value.text : "";
}

ElementChoice::ElementChoice(const AnchorRule& rule)
    : rule_(rule),
      pattern_(regular(rule.pattern)),
      names_(rule.names.begin(), rule.names.end()),
      guids_(rule.guids.begin(), rule.guids.end()) {
  for (const std::string& text : rule.selections) selections_.emplace_back(text);
  for (const std::string& text : rule.panels)
    if (text != "none") panel_selections_.emplace_back(text);
  selecting_.resize(selections_.size()), selecting_panels_.resize(panel_selections_.size());
}

bool ElementChoice::needs_properties() const {
  const auto needs = [](const Selection& s) { return s.needs_properties(); };
  return std::any_of(selections_.begin(), selections_.end(), needs) ||
         std::any_of(panel_selections_.begin(), panel_selections_.end(), needs);
}

bool ElementChoice::is_anchor(const Element& element) {
  if (guids_.contains(element.guid)) return true;
  // What an earlier campaign put beside an anchor bears its name and is none.
  if ((element.object_type == "AsBuiltAnchor" || element.object_type == "AsBuiltPanel") &&
      element.ifc_class == "IfcBuildingElementProxy")
    return false;
  bool selected = false;  // each is asked, to know those that select nothing
  for (std::size_t i = 0; i < selections_.size(); ++i)
    if (selections_[i].matches(facts_of(element))) selected = selecting_[i] = true;
  if (selected) return true;
  if (std::find(rule_.classes.begin(), rule_.classes.end(), element.ifc_class) != rule_.classes.end()) return true;
  for (const std::string* text : {&element.name, &element.tag, &element.guid})
    if (!text->empty() && names_.contains(*text)) return true;
  if (rule_.pattern.empty()) return false;
  // Bounded, because std::regex recurses once a character.
  const auto found = [&](const std::string& text) { return std::regex_search(text.substr(0, 1000), pattern_); };
  return found(element.name) || found(element.object_type) || found(element.type_name) || found(element.tag);
}

bool ElementChoice::is_panel(const Element& element, const std::string& kind) {
  if (rule_.panels.empty()) return may_be_panel(element.ifc_class, kind);
  bool selected = false;
  for (std::size_t i = 0; i < panel_selections_.size(); ++i)
    if (panel_selections_[i].matches(facts_of(element))) selected = selecting_panels_[i] = true;
  return selected;
}

bool ElementChoice::is_cladding(const Element& element, const std::string& kind) const {
  return !rule_.panels.empty() || clads(element.ifc_class, kind);
}

void ElementChoice::tell_idle(Design& design) const {
  const auto idle = [&](const std::string& asked, const char* by) {
    design.not_applied.push_back({asked, by, "it selects nothing in " + design.file_name});
  };
  for (std::size_t i = 0; i < selections_.size(); ++i)
    if (!selecting_[i]) idle(selections_[i].text(), "anchor_selection");
  for (std::size_t i = 0; i < panel_selections_.size(); ++i)
    if (!selecting_panels_[i]) idle(panel_selections_[i].text(), "panel_selection");
  std::unordered_set<std::string> guids;
  for (const Element& element : design.elements) guids.insert(element.guid);
  for (const std::string& guid : rule_.guids)
    if (!guids.contains(guid)) idle(guid, "anchor_guids");
  for (const NotApplied& request : design.not_applied)
    design.warnings.push_back(request.by + " '" + request.asked + "': " + request.reason);
}

}  // namespace plumbline::ifc

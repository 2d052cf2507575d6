// Deviation at panel level: how each panel sits if it follows its anchors.
#include <algorithm>
#include <cmath>
#include <map>

#include "show/report/exact_lengths.hpp"
#include "show/report/format.hpp"
#include "show/report/language.hpp"
#include "show/report/plot.hpp"
#include "show/report/sections.hpp"

namespace plumbline::report {

namespace {

/// Angles as builders measure them, with a spirit level's sense: millimetres in a metre, or inches in a foot.
std::string per_metre(double angle) {
  if (!std::isfinite(angle)) return unknown;
  return speech().units == Units::inches ? signed_fixed(12 * angle, 3) : signed_fixed(1e3 * angle, 1);
}

std::string length(const JudgedLengthT& l) { return mm_with_u(l.value, l.u, 1); }

/// Outward, to the right, leaning and rolling have no sign where nobody confirmed which side is outside.
std::string without_sign(const std::string& text, const PanelDeviationT& panel) {
  const bool lost = !panel.facade || !panel.facade->confirmed;
  return lost && text.starts_with('+') ? text.substr(1) : text;
}

std::vector<std::string> fixings(const PanelDeviationT& panel) {
  std::vector<std::string> texts;
  for (const auto& fixing : panel.fixings) texts.push_back(fixing->anchor + " " + signed_mm(fixing->shim, 1));
  for (const std::string& missing : panel.missing) texts.push_back(missing + " not measured");
  return texts;
}

std::vector<std::string> joints(const PanelDeviationT& panel) {
  std::vector<std::string> texts;
  for (const auto& joint : panel.joints)
    texts.push_back(joint->side + " " + mm(joint->narrowest, 1) + "\u2013" + mm(joint->widest, 1) + " (" +
                    mm(joint->design, 1) + ")");
  return texts;
}

/// One cell; lines break between the texts only, so that a name is not parted from its number.
void write_list(Markup& html, const std::vector<std::string>& texts) {
  Scope td(html, "td", {{"class", "words"}});
  if (texts.empty()) html.text(unknown);
  for (std::size_t i = 0; i < texts.size(); ++i) {
    html.element("span", {{"class", "whole"}}, texts[i] + (i + 1 < texts.size() ? "," : ""));
    html.text(" ");
  }
}

/// `in_plane`: some panel is held against a length in its plane, which then has a column.
void write_row(Markup& html, const PanelDeviationT& panel, const DeviationT& deviation, std::size_t index,
               bool in_plane) {
  const PlacedRow row(html, panel.floor, facade_of(panel.facade), panel.verdict);
  html.element("th", {{"scope", "row"}}, verbatim(panel.name.empty() ? panel.guid : panel.name));
  if (deviation.facades.size() > 1) {
    const std::string facade = facade_of(panel.facade);
    html.element("td", {{"class", "text"}}, facade.empty() ? unknown : verbatim(facade));
  }
  {
    Scope td(html, "td", {{"class", "text"}, {"data-panel", std::to_string(index)}});
    verdict_badge(html, panel.verdict);
  }
  html.element("td", {{"class", "words"}},
               panel.reason.empty() ? words_of(panel.decided_by) : reason_of(panel, deviation));
  html.element("td", without_sign(length(*panel.out_of_plane), panel));
  html.element("td", without_sign(length(*panel.sideways), panel));
  html.element("td", length(*panel.vertical));
  html.element("td", without_sign(per_metre(panel.lean), panel));
  html.element("td", per_metre(panel.turn));
  html.element("td", without_sign(per_metre(panel.roll), panel));
  if (in_plane) html.element("td", panel.in_plane ? length(*panel.in_plane) : unknown);
  for (const auto* l : {panel.tilt.get(), panel.warp.get(), panel.misfit.get(), panel.corner.get()})
    html.element("td", mm(l->value, 1));
  write_list(html, fixings(panel));
  write_list(html, joints(panel));
}

}  // namespace

void write_panels(Markup& html, const DeviationT& deviation) {
  if (deviation.panels.empty()) return;
  std::map<const PanelDeviationT*, std::size_t> index;
  for (std::size_t i = 0; i < deviation.panels.size(); ++i) index[deviation.panels[i].get()] = i;
  const bool in_plane = std::any_of(deviation.panels.begin(), deviation.panels.end(),
                                    [](const auto& panel) { return panel->in_plane != nullptr; });
  Scope part(html, "section", {{"id", "panels"}, {"class", "broad"}});
  html.element("h2", "Panels, first to mend first");
  {
    Scope wide(html, "div", {{"class", "wide"}});
    Scope table(html, "table", {{"class", "sortable"}});
    std::vector<Cell> head = {"Panel",        left("Verdict"),     left("Decided by"),
                              "Out ± u [mm]", "Sideways ± u [mm]", "Vertical ± u [mm]",
                              "Lean [mm/m]",  "Turn [mm/m]",       "Roll [mm/m]"};
    if (deviation.facades.size() > 1) head.insert(head.begin() + 1, left("Facade"));
    if (in_plane) head.emplace_back("In plane ± u [mm]");
    head.insert(head.end(), {"Tilt [mm]", "Warp [mm]", "Slots [mm]", "Corner [mm]",
                             left("Shim per anchor, outward [mm]"), left("Joints as built (design) [mm]")});
    table_head(html, head);
    Scope body(html, "tbody");
    for (const PanelDeviationT* panel : worst_panels_first(deviation))
      write_row(html, *panel, deviation, index[panel], in_plane);
  }
  html.element(
      "p", {{"class", "note"}},
      "How each facade panel sits if it is hung on its anchors as they were built. A stiff panel is moved to fit "
      "its anchors best: out of the facade plane (outward positive), sideways (to the right, seen from outside) "
      "and vertically; it leans (outward at the top), turns (outward at the right) and rolls (up at the right). "
      "Tilt is what these turns move its farthest anchor by, corner the farthest movement of a corner out of the "
      "plane. Warp and slots are what no motion of a stiff panel explains, out of its plane and within it. A "
      "panel is never better than the worst of its anchors and joints.");
}

}  // namespace plumbline::report

// Deviation at panel level: how each panel sits if it follows its anchors.
#include <algorithm>
#include <cmath>

#include "report/format.hpp"
#include "report/plot.hpp"
#include "report/sections.hpp"

namespace plumbline::report {

namespace {

/// Angles as builders measure them, with a spirit level's sense: millimetres in a metre.
std::string per_metre(double angle) { return std::isfinite(angle) ? signed_fixed(1e3 * angle, 1) : unknown; }

std::string length(const JudgedLengthT& l) { return mm_with_u(l.value, l.u, 1); }

/// "tilt", "out of plane".
std::string words_of(std::string name) {
  std::replace(name.begin(), name.end(), '_', ' ');
  return name;
}

std::vector<const PanelAccuracyT*> worst_first(const AccuracyT& accuracy) {
  std::vector<const PanelAccuracyT*> panels;
  for (const auto& panel : accuracy.panels) panels.push_back(panel.get());
  std::stable_sort(panels.begin(), panels.end(),
                   [](const PanelAccuracyT* a, const PanelAccuracyT* b) { return a->verdict > b->verdict; });
  return panels;
}

void write_row(Markup& html, const PanelAccuracyT& panel) {
  Scope row(html, "tr");
  html.element("th", {{"scope", "row"}}, panel.name.empty() ? panel.guid : panel.name);
  {
    Scope td(html, "td", {{"class", "text"}});
    verdict_badge(html, panel.verdict);
  }
  html.element("td", {{"class", "text"}}, words_of(panel.decided_by));
  html.element("td", std::to_string(panel.anchors.size()) + " of " + std::to_string(panel.anchors_listed));
  for (const auto* l : {panel.out_of_plane.get(), panel.sideways.get(), panel.vertical.get()})
    html.element("td", length(*l));
  for (const double angle : {panel.lean, panel.turn, panel.roll}) html.element("td", per_metre(angle));
  for (const auto* l : {panel.tilt.get(), panel.warp.get(), panel.misfit.get()}) html.element("td", mm(l->value, 1));
}

}  // namespace

void write_panels(Markup& html, const AccuracyT& accuracy) {
  if (accuracy.panels.empty()) return;
  Scope part(html, "section", {{"id", "panels"}});
  html.element("h2", "Panels");
  html.element(
      "p",
      "How each facade panel would sit if it were hung on its anchors as they were built, against the design. A "
      "stiff panel is moved to fit its anchors best: out of the facade plane (outward positive), sideways (to "
      "the right, seen from outside) and vertically; it leans (outward at the top), turns (outward at the "
      "right) and rolls (up at the right), in mm per metre. Tilt is what these three turns move its farthest "
      "anchor by. Warp and misfit are what no motion of a stiff panel explains, out of its plane and within "
      "it: shims and slotted holes have to take them up. Each is judged against ±" +
          tolerance(accuracy.tau) + ", and the worst decides.");
  Scope wide(html, "div", {{"class", "wide"}});
  Scope table(html, "table", {{"class", "sortable"}});
  table_head(html, {"Panel", left("Verdict"), left("Decided by"), "Anchors", "Out ± u [mm]", "Sideways ± u [mm]",
                    "Vertical ± u [mm]", "Lean [mm/m]", "Turn [mm/m]", "Roll [mm/m]", "Tilt [mm]", "Warp [mm]",
                    "Misfit [mm]"});
  Scope body(html, "tbody");
  for (const PanelAccuracyT* panel : worst_first(accuracy)) write_row(html, *panel);
}

}  // namespace plumbline::report

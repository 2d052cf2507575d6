#include "show/report/sheets_page.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "building/ifc/doubt_words.hpp"
#include "building/ifc/facade_artifact.hpp"
#include "building/ifc/shift_words.hpp"
#include "show/report/exact_lengths.hpp"
#include "show/report/format.hpp"
#include "show/report/language.hpp"
#include "show/report/plot.hpp"
#include "show/report/sections.hpp"

namespace plumbline::report {

namespace {

struct Sheet {
  std::string facade;
  int floor = 0;
  std::vector<const AnchorDeviationT*> anchors;
  std::vector<const PanelDeviationT*> panels;
};

std::vector<Sheet> sheets_of(const DeviationT& deviation) {
  std::vector<std::string> order;
  for (const auto& facade : deviation.facades) order.push_back(facade->name);
  std::map<std::pair<std::size_t, int>, Sheet> sheets;
  const auto sheet_of = [&](const auto& element) -> Sheet& {
    const std::string facade = element.facade ? element.facade->facade : "";
    const auto at = std::find(order.begin(), order.end(), facade);
    Sheet& sheet = sheets[{static_cast<std::size_t>(at - order.begin()), element.floor}];
    sheet.facade = facade, sheet.floor = element.floor;
    return sheet;
  };
  for (const AnchorDeviationT* anchor : worst_first(deviation)) sheet_of(*anchor).anchors.push_back(anchor);
  for (const PanelDeviationT* panel : worst_panels_first(deviation)) sheet_of(*panel).panels.push_back(panel);
  std::vector<Sheet> all;
  for (auto& [key, sheet] : sheets) all.push_back(std::move(sheet));
  return all;
}

std::string storey_of(const DeviationT& deviation, int floor) {
  for (const auto& f : deviation.floors)
    if (f->floor == floor) return f->storey;
  return "";
}

/// Deviation to the right, up and out; along x, y, z where nobody confirmed which way that is.
std::string deviation_of(const AnchorDeviationT& anchor) {
  if (!anchor.deviation.allFinite()) return unknown;
  const ifc::FacadeFrame frame = ifc::frame_or_none(anchor.facade);
  const Eigen::Vector3d& d = anchor.deviation;
  if (!frame.known() || !frame.confirmed)
    return "x " + signed_mm(d.x(), 1) + ", y " + signed_mm(d.y(), 1) + ", z " + signed_mm(d.z(), 1);
  return signed_mm(frame.right.dot(d), 1) + " / " + signed_mm(frame.up.dot(d), 1) + " / " +
         signed_mm(frame.out.dot(d), 1);
}

/// `grid` where the design has one.
void write_row(Markup& html, const std::string& what, const std::optional<std::string>& grid, ToleranceVerdict verdict,
               const std::string& found, const std::string& todo) {
  Scope row(html, "tr");
  html.element("th", {{"scope", "row"}}, what);
  if (grid) html.element("td", {{"class", "text"}}, *grid);
  verdict_cell(html, verdict);
  html.element("td", {{"class", "words"}}, found);
  html.element("td", {{"class", "words todo"}}, todo);
  html.element("td", {{"class", "by hand"}}, "");
}

void write_list(Markup& html, const Sheet& sheet, const ReportInput& input) {
  Scope table(html, "table", {{"class", "list"}});
  const bool with_grid = !input.grid.empty();
  std::vector<Cell> heads = {left("What")};
  if (with_grid) heads.push_back(left("Grid"));
  heads.insert(heads.end(), {left("Verdict"), left("Right / up / out of the design [mm]; what of a panel"),
                             left("To do"), left("Done, by")});
  table_head(html, heads);
  Scope body(html, "tbody");
  for (const AnchorDeviationT* anchor : sheet.anchors)
    write_row(html, "Anchor " + anchor->id,
              with_grid ? std::optional(verbatim(place_in_grid(input, anchor->design))) : std::nullopt, anchor->verdict,
              deviation_of(*anchor),
              anchor->verdict == ToleranceVerdict::pass ? "" : what_to_do(*anchor, *input.deviation));
  for (const PanelDeviationT* panel : sheet.panels)
    write_row(html, "Panel " + (panel->name.empty() ? panel->guid : panel->name),
              with_grid ? std::optional(std::string()) : std::nullopt, panel->verdict,
              reason_of(*panel, *input.deviation),
              panel->verdict == ToleranceVerdict::pass ? "" : what_to_do(*panel, *input.deviation));
}

void write_sheet(Markup& html, const Sheet& sheet, const ReportInput& input, std::size_t number, std::size_t of) {
  const DeviationT& deviation = *input.deviation;
  Scope part(html, "section", {{"class", "sheet"}});
  {
    Scope head(html, "header");
    const std::string storey = storey_of(deviation, sheet.floor);
    html.element("h2", (sheet.facade.empty() ? "No facade that is known" : "Facade " + sheet.facade) + ", " +
                           (sheet.floor > 0 ? "floor " + std::to_string(sheet.floor) : "unknown floor") +
                           (storey.empty() ? "" : " (" + storey + ")"));
    html.element("p", {{"class", "soft"}},
                 title_spoken(input.title) + (input.subtitle.empty() ? "" : ", " + input.subtitle) + "; tolerance " +
                     tolerance(deviation.tau) + "; sheet " + std::to_string(number) + " of " + std::to_string(of));
    for (const auto& doubt : deviation.doubts)
      html.element("p", {{"class", "warnings"}}, "Not to be trusted, " + ifc::in_words(*doubt) + ".");
    for (const auto& misfit : deviation.misfits)
      html.element("p", {{"class", "warnings"}}, "Less certain, " + ifc::in_words(*misfit));
    for (const std::string& words : ifc::shift_words(deviation)) html.element("p", {{"class", "warnings"}}, words);
    for (const auto& request : deviation.requests)
      if (!request->not_judged.empty())
        html.element("p", {{"class", "warnings"}}, "Not judged: " + request->asked + ": " + request->not_judged + ".");
  }
  const FacadeT* facade = nullptr;
  for (const auto& one : deviation.facades)
    if (one->name == sheet.facade) facade = one.get();
  if (facade && !facade->confirmed)
    html.element("p", {{"class", "warnings"}},
                 "Which way this facade faces is not confirmed: nobody may be sent outward or inward here.");
  write_floor_elevation(html, input, facade, sheet.floor);
  write_list(html, sheet, input);
}

}  // namespace

std::string render_sheets(const ReportInput& input) {
  const std::string title = title_spoken(input.title) + (input.subtitle.empty() ? "" : ", " + input.subtitle);
  return render_page(title, [&](Markup& html) {
    Scope main(html, "main");
    html.element("h1", {{"class", "screen"}}, title_spoken(input.title));
    const std::vector<Sheet> sheets = sheets_of(*input.deviation);
    html.element("p", {{"class", "screen"}},
                 count(static_cast<long>(sheets.size()), "sheet", "sheets") +
                     ", one for each facade and floor; print them (A4).");
    for (std::size_t i = 0; i < sheets.size(); ++i) write_sheet(html, sheets[i], input, i + 1, sheets.size());
  });
}

}  // namespace plumbline::report

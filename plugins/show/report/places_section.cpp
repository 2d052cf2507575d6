// Floors and grid axes: how the anchors of each stand against the design on the whole.
#include <algorithm>
#include <cmath>

#include "building/judgement/place_statistics.hpp"
#include "show/report/format.hpp"
#include "show/report/language.hpp"
#include "show/report/plot.hpp"
#include "show/report/sections.hpp"

namespace plumbline::report {

namespace {

std::string mean_and_spread(double mean, double spread) {
  if (!std::isfinite(mean)) return unknown;
  return signed_mm(mean, 1) + (std::isfinite(spread) ? " (" + mm(spread, 1) + ")" : "");
}

}  // namespace

std::string place_in_grid(const ReportInput& input, const Eigen::Vector3d& design) {
  return design.allFinite() ? ifc::grid_place(input.grid, design) : std::string();
}

void write_places(Markup& html, const ReportInput& input) {
  const DeviationT& deviation = *input.deviation;
  const auto rows = judgement::place_statistics(deviation, [&](const AnchorDeviationT& anchor) {
    const auto* axis = anchor.facade ? ifc::axis_across(input.grid, anchor.design, anchor.facade->out) : nullptr;
    return axis ? axis->tag : std::string();
  });
  if (rows.empty()) return;
  const bool axes = std::any_of(rows.begin(), rows.end(), [](const auto& row) { return row.kind == "axis"; });
  Scope part(html, "section", {{"id", "places"}});
  html.element("h2", axes ? "Floors and grid axes" : "Floors");
  html.element("p",
               std::string("Mean of as-built minus design, and in brackets how far single anchors scatter about it "
                           "[mm], as one stands before the facade.") +
                   (axes ? " An anchor counts at the axis that crosses its facade nearest to it." : ""));
  Scope wide(html, "div", {{"class", "wide"}});
  Scope table(html, "table", {{"class", "sortable"}});
  table_head(html,
             {left("Facade"), left("Place"), "Anchors", "pass", "undecided", "fail", "To the right", "Up", "Out"});
  Scope body(html, "tbody");
  for (const auto& row : rows) {
    Scope tr(html, "tr");
    html.element("th", {{"scope", "row"}}, row.facade.empty() ? unknown : verbatim(row.facade));
    html.element("td", {{"class", "text"}}, (row.kind == "axis" ? "Axis " : "Floor ") + row.name);
    html.element("td", std::to_string(row.measured) +
                           (row.measured < row.anchors ? " of " + std::to_string(row.anchors) : std::string()));
    for (const int n : {row.passed, row.undecided, row.failed}) html.element("td", std::to_string(n));
    // Nobody is told left or in where it may be right or out.
    html.element("td", row.confirmed ? mean_and_spread(row.mean.x(), row.spread.x()) : unknown);
    html.element("td", mean_and_spread(row.mean.y(), row.spread.y()));
    html.element("td", row.confirmed ? mean_and_spread(row.mean.z(), row.spread.z()) : unknown);
  }
}

}  // namespace plumbline::report

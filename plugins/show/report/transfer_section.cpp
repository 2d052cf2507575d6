// Height transfer between adjacent floors, and drift along each marker column.
#include <algorithm>

#include "show/report/anchor_names.hpp"
#include "show/report/format.hpp"
#include "show/report/sections.hpp"

namespace plumbline::report {

namespace {

using Names = std::map<int, std::string>;

void cell(Markup& html, const std::string& text) { html.element("td", text); }
void words(Markup& html, const std::string& text) { html.element("td", {{"class", "text"}}, text); }

void write_transfer_rows(Markup& html, const AccuracyComparisonT& c, const Names& names, bool columns_only,
                         const std::string& remark) {
  for (const auto& t : c.transfers) {
    if (columns_only && t->column == 0) continue;
    Scope row(html, "tr");
    html.element("th", {{"scope", "row"}}, std::to_string(t->lower_floor) + " → " + std::to_string(t->upper_floor));
    words(html, (t->column == 0 ? std::string("floor means") : names.at(t->column)) + remark);
    cell(html, std::to_string(t->anchors));
    cell(html, mm_with_u(t->difference, t->u));
    cell(html, mm(t->error));
    verdict_cell(html, t->verdict);
  }
}

void write_transfer_table(Markup& html, const AccuracyT& accuracy, const AccuracyComparisonT& c,
                          const AccuracyComparisonT* borrowed, const Names& names) {
  Scope wide(html, "div", {{"class", "wide"}});
  Scope table(html, "table", {{"class", "sortable"}});
  table_head(html, {"Floors", left("Where"), "Anchors", "Model minus survey ± u [mm]", "E transfer [mm]",
                    left("Against ±" + tolerance(accuracy.tau))});
  Scope body(html, "tbody");
  write_transfer_rows(html, c, names, false, "");
  if (borrowed) write_transfer_rows(html, *borrowed, names, true, " (control)");
}

void write_column_table(Markup& html, const AccuracyT& accuracy, const AccuracyComparisonT& c, const Names& names) {
  html.element("h3", "Drift along each marker column");
  html.element("p",
               "The height error of the top floor against the lowest in one vertical line, and its trend from floor to "
               "floor. " +
                   std::string(c.drift_computed ? "D adds the residuals of the column up, as D(F) does for floor means."
                                                : "These are control anchors: not evidence of accuracy."));
  Scope wide(html, "div", {{"class", "wide"}});
  Scope table(html, "table", {{"class", "sortable"}});
  const Cell against = left("Against ±" + tolerance(accuracy.tau));
  table_head(html, {"Column", left("Floors"), "Anchors", "Top against bottom ± u [mm]", against,
                    "Trend per floor ± u [mm]", "D ± u [mm]", against});
  Scope body(html, "tbody");
  for (const auto& column : c.columns) {
    Scope row(html, "tr");
    html.element("th", {{"scope", "row"}}, names.at(column->column));
    words(html, std::to_string(column->lowest_floor) + " to " + std::to_string(column->highest_floor));
    cell(html, std::to_string(column->anchors));
    cell(html, mm_with_u(column->relative_drift, column->u_relative_drift));
    verdict_cell(html, column->relative_verdict);
    cell(html, column->slope ? mm_with_u(column->slope->per_floor, column->slope->u_per_floor) : unknown);
    cell(html, mm_with_u(column->drift, column->u_drift));
    verdict_cell(html, column->drift_verdict);
  }
}

}  // namespace

void write_transfers(Markup& html, const AccuracyT& accuracy) {
  const AccuracyComparisonT* c = headline(accuracy);
  Scope part(html, "section", {{"id", "transfer"}});
  html.element("h2", "Height transfer between floors");
  if (!c || c->transfers.empty()) {
    html.element("p", "No two adjacent floors have anchors to compare.");
    return;
  }
  const Names names = column_names(accuracy);
  const AccuracyComparisonT* control = comparison(accuracy, AnchorUse::control, AccuracyReference::survey);
  const bool borrow = c->use == AnchorUse::check && c->columns.empty() && control && !control->columns.empty();
  html.element(
      "p",
      "Error of the height difference between two adjacent floors. The mean of the floors tells how storeys agree; a "
      "single column tells what a panel feels that spans both floors there." +
          std::string(borrow ? " The check anchors stand in no common column, so the columns are those of control "
                               "anchors: not evidence of accuracy, but a blunder would show."
                             : ""));
  write_transfer_table(html, accuracy, *c, borrow ? control : nullptr, names);
  const AccuracyComparisonT& columns = borrow ? *control : *c;
  if (!columns.columns.empty()) write_column_table(html, accuracy, columns, names);
}

}  // namespace plumbline::report

// Table of all anchors, those to be mended first on top; and every number of each.
#include <algorithm>
#include <cmath>
#include <map>

#include "building/ifc/tolerance_source.hpp"
#include "show/report/format.hpp"
#include "show/report/language.hpp"
#include "show/report/plot.hpp"
#include "show/report/sections.hpp"

namespace plumbline::report {

namespace {

/// An anchor with what is known of it: either may be null.
struct Entry {
  const AnchorAccuracyT* measured = nullptr;
  const AnchorDeviationT* built = nullptr;
  std::size_t index = 0;  ///< of `built` in the artifact, for the script
  const std::string& id() const { return measured ? measured->id : built->id; }
};

int severity(ToleranceVerdict verdict, bool known) {
  if (!known || verdict == ToleranceVerdict::not_measured) return 1;
  return verdict == ToleranceVerdict::fail ? 3 : verdict == ToleranceVerdict::undecided ? 2 : 0;
}

std::vector<Entry> entries_of(const ReportInput& input) {
  std::map<std::string, const AnchorAccuracyT*> measured;
  for (const auto& a : input.accuracy.anchors) measured[a->id] = a.get();
  std::vector<Entry> entries;
  if (input.deviation) {
    std::map<const AnchorDeviationT*, std::size_t> index;
    for (std::size_t i = 0; i < input.deviation->anchors.size(); ++i) index[input.deviation->anchors[i].get()] = i;
    for (const AnchorDeviationT* built : worst_first(*input.deviation)) {
      const auto found = measured.find(built->id);
      entries.push_back({found == measured.end() ? nullptr : found->second, built, index[built]});
      measured.erase(built->id);
    }
  }
  std::vector<Entry> rest;
  for (const auto& a : input.accuracy.anchors)
    if (measured.contains(a->id)) rest.push_back({a.get(), nullptr, 0});
  std::stable_sort(rest.begin(), rest.end(), [](const Entry& a, const Entry& b) {
    const AnchorDifferenceT *x = a.measured->survey.get(), *y = b.measured->survey.get();
    const int first = severity(x ? x->verdict : ToleranceVerdict::not_measured, x),
              second = severity(y ? y->verdict : ToleranceVerdict::not_measured, y);
    if (first != second) return first > second;
    return (x ? std::abs(x->dz) : 0) > (y ? std::abs(y->dz) : 0);
  });
  entries.insert(entries.end(), rest.begin(), rest.end());
  return entries;
}

/// Of the plane, of the facade and in space: lengths without a direction, so without a sign; and so is what lies across
/// a facade of which nobody confirmed the outside.
std::string axis_with_u(const JudgedAxisT& axis, const AnchorDeviationT& anchor) {
  std::string text = mm_with_u(axis.value, axis.u, 1);
  const bool directed =
      axis.axis == "vertical" || (axis.axis == "out_of_plane" && anchor.facade && anchor.facade->confirmed);
  return !directed && text.starts_with('+') ? text.substr(1) : text;
}

void write_built_cells(Markup& html, const Entry& entry) {
  const AnchorDeviationT* d = entry.built;
  {
    Scope td(html, "td", {{"class", "text"}, {"data-anchor", d ? std::to_string(entry.index) : ""}});
    verdict_badge(html, d ? d->verdict : ToleranceVerdict::not_measured);
  }
  const JudgedAxisT* axis = d ? deciding_axis(*d) : nullptr;
  html.element("td", {{"class", "text"}}, axis ? words_of(axis->axis) : unknown);
  for (const char* name : {"horizontal", "vertical", "out_of_plane"}) {
    const JudgedAxisT* found = nullptr;
    for (std::size_t i = 0; d && i < d->axes.size(); ++i)
      if (d->axes[i]->axis == name) found = d->axes[i].get();
    html.element("td", found ? axis_with_u(*found, *d) : unknown);
  }
  html.element("td", d ? percent(d->pass_probability) : unknown);
}

void write_row(Markup& html, const Entry& entry, const ReportInput& input, bool with_truth) {
  const bool with_design = input.deviation.has_value();
  const AnchorAccuracyT* a = entry.measured;
  const int floor = entry.built ? entry.built->floor : a->floor;
  const PlacedRow row(html, floor, entry.built ? facade_of(entry.built->facade) : "",
                      entry.built ? entry.built->verdict : ToleranceVerdict::not_measured);
  html.element("th", {{"scope", "row"}}, verbatim(entry.id()));
  html.element("td", floor > 0 ? std::to_string(floor) : unknown);
  if (with_design && input.deviation->facades.size() > 1) {
    const std::string facade = entry.built ? facade_of(entry.built->facade) : "";
    html.element("td", {{"class", "text"}}, facade.empty() ? unknown : verbatim(facade));
  }
  if (with_design && !input.grid.empty()) {
    const std::string place = entry.built ? place_in_grid(input, entry.built->design) : "";
    html.element("td", {{"class", "text"}}, place.empty() ? unknown : verbatim(place));
  }
  if (with_design) write_built_cells(html, entry);
  html.element("td", {{"class", "text"}}, a ? EnumNameAnchorUse(a->use) : unknown);
  const AnchorDifferenceT* d = a ? a->survey.get() : nullptr;
  {
    Scope td(html, "td", {{"class", "text"}});
    verdict_badge(html, d ? d->verdict : ToleranceVerdict::not_measured);
  }
  html.element("td", d ? mm_with_u(d->dz, d->u_dz) : unknown);
  html.element("td", d ? mm(d->distance) : unknown);
  html.element("td", d ? percent(d->conformance_probability) : unknown);
  if (with_truth) html.element("td", a && a->truth ? mm_with_u(a->truth->dz, a->truth->u_dz) : unknown);
}

void write_missing(Markup& html, const std::vector<Entry>& entries) {
  std::string text;
  for (const Entry& entry : entries) {
    const std::string& note = entry.built && !entry.built->note.empty() ? entry.built->note
                              : entry.measured                          ? entry.measured->note
                                                                        : entry.built->note;
    if (!note.empty()) text += (text.empty() ? "" : "; ") + entry.id() + ": " + note;
  }
  if (!text.empty()) html.element("p", {{"class", "note"}}, "Without verdict: " + text + ".");
}

std::string position(const Eigen::Vector3d& p) {
  if (!p.allFinite()) return unknown;
  return fixed(p.x(), 4) + " " + fixed(p.y(), 4) + " " + fixed(p.z(), 4);
}

/// Every number of every anchor: what a site sheet needs.
void write_all_numbers(Markup& html, const DeviationT& deviation) {
  Scope wide(html, "div", {{"class", "wide"}});
  Scope table(html, "table", {{"class", "sortable"}});
  table_head(html, {"Anchor", left("Element"), left("Found by"), left("Reference point"), left("Design x y z [m]"),
                    left("As built x y z [m]"), "dx [mm]", "dy [mm]", "dz [mm]", "u x [mm]", "u y [mm]", "u z [mm]",
                    "In plane ± u [mm]", "In space ± u [mm]", left("Tolerances [mm]")});
  Scope body(html, "tbody");
  for (const AnchorDeviationT* a : worst_first(deviation)) {
    const bool known = a->covariance.size() == 9;
    const auto u = [&](std::size_t i) { return known ? mm(std::sqrt(std::max(0.0, a->covariance[4 * i]))) : unknown; };
    std::string tolerances, in_plane = unknown, in_space = unknown;
    for (const auto& axis : a->axes) {
      if (axis->axis == "in_plane") in_plane = axis_with_u(*axis, *a);
      if (axis->axis == "space") in_space = axis_with_u(*axis, *a);
      if (axis->tolerance > 0)
        tolerances += (tolerances.empty() ? "" : ", ") + words_of(axis->axis) + " " + mm(axis->tolerance, 1) +
                      (ifc::is_default_tolerance(axis->source) ? "" : " (" + axis->source + ")");
    }
    table_row(html, {verbatim(a->id), left(a->guid.empty() ? unknown : verbatim(a->class_ + " " + a->guid)),
                     left(a->found_by.empty() ? unknown : a->found_by),
                     left(a->reference_point_rule.empty() ? unknown : words_of(a->reference_point_rule)),
                     left(position(a->design)), left(position(a->as_built)), signed_mm(a->deviation.x()),
                     signed_mm(a->deviation.y()), signed_mm(a->deviation.z()), u(0), u(1), u(2), in_plane, in_space,
                     left(tolerances.empty() ? unknown : tolerances)});
  }
}

}  // namespace

void write_anchors(Markup& html, const ReportInput& input) {
  const AccuracyT& accuracy = input.accuracy;
  const bool with_truth =
      std::any_of(accuracy.anchors.begin(), accuracy.anchors.end(), [](const auto& a) { return a->truth != nullptr; });
  const bool with_design = input.deviation.has_value();
  const std::vector<Entry> entries = entries_of(input);
  Scope part(html, "section", {{"id", "anchors"}});
  html.element("h2", with_design ? "All anchors, first to mend first" : "Anchors, worst first");
  {
    Scope wide(html, "div", {{"class", "wide"}});
    Scope table(html, "table", {{"class", "sortable"}});
    std::vector<Cell> heads = {"Anchor", "Floor"};
    if (with_design && input.deviation->facades.size() > 1) heads.push_back(left("Facade"));
    if (with_design && !input.grid.empty()) heads.push_back(left("Grid"));
    if (with_design)
      heads.insert(heads.end(), {left("Built"), left("Decided by"), "Horizontal ± u [mm]", "Height ± u [mm]",
                                 "Out of plane ± u [mm]", "within"});
    heads.insert(heads.end(), {left("Use"), left("Measured"), "Δz to survey ± u [mm]", "in space [mm]", "within"});
    if (with_truth) heads.push_back("Δz to truth ± u [mm]");
    table_head(html, heads);
    Scope body(html, "tbody");
    for (const Entry& entry : entries) write_row(html, entry, input, with_truth);
  }
  write_missing(html, entries);
  html.element("p", {{"class", "note"}},
               std::string(with_design ? "Built: as-built against the design, in all judged directions. " : "") +
                   "Measured: model against survey in height, ±" + tolerance(accuracy.tau) +
                   ". Within: probability that the true deviation is inside the tolerance.");
  if (with_design && many(*input.deviation))
    html.element("p", {{"class", "note"}},
                 "Every number of every anchor stands in metrics.csv and stake_out.csv. On paper the tables of anchors "
                 "and panels end after 200 rows; sheets.html has all, a sheet for each facade and floor.");
  else if (with_design)
    folded(
        html, "Every number of every anchor", [&] { write_all_numbers(html, *input.deviation); }, "broad");
}

}  // namespace plumbline::report

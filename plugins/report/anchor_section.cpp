// Table of all anchors, worst first.
#include <algorithm>
#include <cmath>

#include "report/format.hpp"
#include "report/plot.hpp"
#include "report/sections.hpp"

namespace plumbline::report {

namespace {

int severity(const AnchorAccuracyT& a) {
  if (!a.survey) return 2;
  switch (a.survey->verdict) {
    case ToleranceVerdict::fail:
      return 3;
    case ToleranceVerdict::undecided:
      return 1;
    default:
      return 0;
  }
}

/// Fail before not measured before undecided before pass; then check before control; then the larger residual.
std::vector<const AnchorAccuracyT*> worst_first(const AccuracyT& accuracy) {
  std::vector<const AnchorAccuracyT*> anchors;
  for (const auto& a : accuracy.anchors) anchors.push_back(a.get());
  std::stable_sort(anchors.begin(), anchors.end(), [](const AnchorAccuracyT* a, const AnchorAccuracyT* b) {
    if (severity(*a) != severity(*b)) return severity(*a) > severity(*b);
    if (a->use != b->use) return a->use == AnchorUse::check;
    return (a->survey ? std::abs(a->survey->dz) : 0) > (b->survey ? std::abs(b->survey->dz) : 0);
  });
  return anchors;
}

void write_difference_cells(Markup& html, const AnchorDifferenceT* d) {
  html.element("td", d ? mm_with_u(d->dz, d->u_dz) : unknown);
  html.element("td", d ? mm(d->distance) : unknown);
}

void verdict_cell_of(Markup& html, const AnchorDifferenceT* d) {
  Scope td(html, "td", {{"class", "text"}});
  verdict_badge(html, d ? d->verdict : ToleranceVerdict::not_measured);
}

void write_row(Markup& html, const AnchorAccuracyT& a, bool with_truth, bool with_design) {
  Scope row(html, "tr");
  html.element("th", {{"scope", "row"}}, a.id);
  html.element("td", a.floor > 0 ? std::to_string(a.floor) : unknown);
  html.element("td", a.column > 0 ? std::to_string(a.column) : unknown);
  html.element("td", {{"class", "text"}}, EnumNameAnchorUse(a.use));
  verdict_cell_of(html, a.survey.get());
  write_difference_cells(html, a.survey.get());
  html.element("td", a.survey ? percent(a.survey->conformance_probability) : unknown);
  if (with_truth) html.element("td", a.truth ? mm_with_u(a.truth->dz, a.truth->u_dz) : unknown);
  if (with_design) {
    const AnchorDifferenceT* d = a.design.get();
    verdict_cell_of(html, d);
    html.element("td", d ? signed_mm(d->dz, 1) : unknown);
    html.element("td", d ? mm(d->distance, 1) : unknown);
  }
}

void write_missing(Markup& html, const AccuracyT& accuracy) {
  std::string text;
  for (const auto& a : accuracy.anchors)
    if (!a->note.empty()) text += (text.empty() ? "" : "; ") + a->id + ": " + a->note;
  if (!text.empty()) html.element("p", {{"class", "note"}}, "Not measured: " + text + ".");
}

}  // namespace

void write_anchors(Markup& html, const AccuracyT& accuracy) {
  const bool with_truth =
      std::any_of(accuracy.anchors.begin(), accuracy.anchors.end(), [](const auto& a) { return a->truth != nullptr; });
  const bool with_design = accuracy.design != nullptr && accuracy.design->anchors > 0;
  Scope part(html, "section", {{"id", "anchors"}});
  html.element("h2", "Anchors, worst first");
  {
    Scope wide(html, "div", {{"class", "wide"}});
    Scope table(html, "table", {{"class", "sortable"}});
    std::vector<Cell> heads = {"Anchor",        "Floor",       "Col.",          left("Use"),
                               left("Verdict"), "Δz ± u [mm]", "in space [mm]", "within"};
    if (with_truth) heads.push_back("Δz to truth ± u [mm]");
    if (with_design) heads.insert(heads.end(), {left("Built"), "Δz to design [mm]", "in space [mm]"});
    table_head(html, heads);
    Scope body(html, "tbody");
    for (const AnchorAccuracyT* a : worst_first(accuracy)) write_row(html, *a, with_truth, with_design);
  }
  write_missing(html, accuracy);
  html.element("p", {{"class", "note"}},
               "Verdict: model against survey in height, ±" + tolerance(accuracy.tau) +
                   ". Within: probability that the true deviation is "
                   "inside the tolerance." +
                   (with_design ? " Built: height against the design, same tolerance." : ""));
}

}  // namespace plumbline::report

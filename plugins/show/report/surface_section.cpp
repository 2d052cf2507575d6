// Surfaces of panels and joints against their rules: what fails first, what nobody can judge next.
#include <algorithm>
#include <cmath>
#include <set>
#include <tuple>

#include "building/ifc/surface_words.hpp"
#include "show/report/format.hpp"
#include "show/report/language.hpp"
#include "show/report/plot.hpp"
#include "show/report/sections.hpp"
#include "show/report/surface_page.hpp"

namespace plumbline::report {

namespace {

/// Fail, not judged, undecided, pass.
int surface_order(const SurfaceVerdictT& verdict) {
  if (!verdict.not_judged.empty()) return 1;
  if (verdict.verdict == ToleranceVerdict::fail) return 0;
  return verdict.verdict == ToleranceVerdict::undecided ? 2 : 3;
}

void write_surface_row(Markup& html, const SurfaceVerdictT& verdict) {
  Scope row(html, "tr");
  html.element("th", {{"scope", "row"}}, verbatim(surface_name(verdict)));
  html.element("td", {{"class", "text"}}, ifc::quantity_of(verdict));
  {
    Scope td(html, "td", {{"class", "text"}});
    if (verdict.not_judged.empty())
      verdict_badge(html, verdict.verdict);
    else
      html.text("not judged");
  }
  html.element("td", mm_with_u(verdict.value, verdict.sigma, 2));
  html.element("td", surface_limit(verdict));
  html.element("td", std::isfinite(verdict.probability) ? probability(verdict.probability) : std::string(unknown));
  html.element("td", verdict.second.empty()
                         ? std::string(unknown)
                         : std::to_string(verdict.places) + " of " + std::to_string(verdict.looked_at));
  html.element("td", {{"class", "words"}}, verdict.not_judged.empty() ? verdict.rule : verdict.not_judged);
}

void write_surface_table(Markup& html, const std::vector<const SurfaceVerdictT*>& verdicts) {
  Scope wide(html, "div", {{"class", "wide"}});
  Scope table(html, "table", {{"class", "sortable"}});
  table_head(html, {"Panel or joint", left("Quantity"), left("Verdict"), "Value ± u [mm]", "Limit [mm]",
                    "Kept with a probability of", "Places", left("Rule, or why it is not judged")});
  Scope body(html, "tbody");
  for (const SurfaceVerdictT* verdict : verdicts) write_surface_row(html, *verdict);
}

}  // namespace

std::string surface_limit(const SurfaceVerdictT& verdict) {
  std::string text;
  if (std::isfinite(verdict.lower)) text = mm(verdict.lower, 1);
  if (std::isfinite(verdict.upper)) text += (text.empty() ? "at most " : " to ") + mm(verdict.upper, 1);
  return std::isfinite(verdict.upper) || text.empty() ? text : "at least " + text;
}

std::string surface_name(const SurfaceVerdictT& verdict) {
  return verdict.second.empty() ? verdict.panel : verdict.panel + " | " + verdict.second;
}

std::vector<const SurfaceVerdictT*> worst_surfaces_first(const SurfaceJudgementT& judgement) {
  std::vector<const SurfaceVerdictT*> worst;
  for (const ToleranceVerdict wanted : {ToleranceVerdict::fail, ToleranceVerdict::undecided})
    for (const auto& verdict : judgement.verdicts)
      if (verdict->verdict == wanted) worst.push_back(verdict.get());
  return worst;
}

int surfaces_with(const SurfaceJudgementT& judgement, ToleranceVerdict wanted) {
  std::set<std::tuple<std::string, std::string, std::string, int>> found;
  for (const auto& verdict : judgement.verdicts)
    if (verdict->verdict == wanted) found.emplace(verdict->panel, verdict->guid, verdict->second, verdict->item);
  return static_cast<int>(found.size());
}

std::string surface_counts(const SurfaceJudgementT& judgement) {
  return std::to_string(judgement.passed) + " pass, " + std::to_string(judgement.undecided) + " undecided, " +
         std::to_string(judgement.failed) + " fail, " + std::to_string(judgement.not_judged) + " not judged";
}

void write_surfaces(Markup& html, const SurfaceJudgementT& judgement) {
  std::vector<const SurfaceVerdictT*> open, passed;
  for (const auto& verdict : judgement.verdicts)
    (surface_order(*verdict) == 3 ? passed : open).push_back(verdict.get());
  std::stable_sort(open.begin(), open.end(), [](const SurfaceVerdictT* a, const SurfaceVerdictT* b) {
    return surface_order(*a) < surface_order(*b);
  });
  Scope part(html, "section", {{"id", "surfaces"}});
  html.element("h2", "Verdicts on surfaces and joints");
  html.element("p", surface_counts(judgement) + ".");
  std::vector<std::string> unanswered;
  for (const auto& request : judgement.requests)
    if (!request->not_judged.empty()) unanswered.push_back(request->asked + ": " + request->not_judged);
  if (!unanswered.empty()) {
    Scope box(html, "div", {{"class", "warnings"}});
    html.element("h2", "Asked for and not judged");
    Scope list(html, "ul");
    for (const std::string& text : unanswered) html.element("li", text);
  }
  for (const std::string& remark : judgement.remarks) html.element("p", {{"class", "note"}}, remark);
  if (!open.empty()) write_surface_table(html, open);
  if (!passed.empty())
    folded(html, count(static_cast<long>(passed.size()), "quantity keeps its limit", "quantities keep their limits"),
           [&] { write_surface_table(html, passed); });
  html.element(
      "p", {{"class", "note"}},
      "Flatness is the largest gap under a straightedge of that length, bow the middle over the edges, offset what a "
      "corner stands out of the design's face; step, joint (the width against the design's), narrowest, widest and "
      "shift (of the joint beside its place in the design) are those of the place along the joint that keeps its "
      "limit least well. The probability is that the limit is kept everywhere, given what was "
      "measured and how surely.");
  html.element("p", {{"class", "note"}}, kTemperature);
}

}  // namespace plumbline::report

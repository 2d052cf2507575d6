// What was asked, what was judged, by which tolerance and from where: nothing is left out.
#include <cmath>
#include <map>
#include <tuple>

#include "show/report/format.hpp"
#include "show/report/language.hpp"
#include "show/report/plot.hpp"
#include "show/report/sections.hpp"

namespace plumbline::report {

namespace {

/// Anchors that are held against the same tolerance along the same axis.
struct Share {
  int counts[4] = {};  // by verdict of the axis
};

std::string limits(double below, double above) {
  if (std::abs(below - above) < 1e-9) return "±" + tolerance(above);
  return "+" + tolerance(above) + " / −" + tolerance(below);
}

void write_shares(Markup& html, const DeviationT& deviation) {
  std::map<std::tuple<std::string, std::string, std::string>, Share> shares;  // axis, source, limits
  for (const auto& anchor : deviation.anchors)
    for (const auto& axis : anchor->axes)
      if (axis->above > 0 || axis->below > 0)
        ++shares[{axis->axis, axis->source, limits(axis->below, axis->above)}].counts[static_cast<int>(axis->verdict)];
  Scope wide(html, "div", {{"class", "wide"}});
  Scope table(html, "table");
  table_head(html, {left("Anchors are judged"), left("Tolerance"), left("Given by"), "pass", "undecided", "fail",
                    "not measured"});
  Scope body(html, "tbody");
  for (const auto& [key, share] : shares) {
    const auto& [axis, source, text] = key;
    Scope row(html, "tr");
    html.element("th", {{"scope", "row"}}, words_of(axis));
    html.element("td", {{"class", "text"}}, text);
    html.element("td", {{"class", "words"}}, source);
    for (const ToleranceVerdict verdict :
         {ToleranceVerdict::pass, ToleranceVerdict::undecided, ToleranceVerdict::fail, ToleranceVerdict::not_measured})
      html.element("td", std::to_string(share.counts[static_cast<int>(verdict)]));
  }
}

void write_requests(Markup& html, const DeviationT& deviation) {
  if (deviation.requests.empty()) return;
  html.element("h3", "What was asked for beside the default tolerance");
  Scope wide(html, "div", {{"class", "wide"}});
  Scope table(html, "table");
  table_head(html, {left("Asked"), left("By"), "Anchors", "Panels", left("Judged")});
  Scope body(html, "tbody");
  for (const auto& request : deviation.requests) {
    Scope row(html, "tr");
    html.element("th", {{"scope", "row"}, {"class", "words"}}, request->asked);
    html.element("td", {{"class", "text"}}, request->by);
    html.element("td", std::to_string(request->anchors));
    html.element("td", std::to_string(request->panels));
    html.element("td", {{"class", "words"}},
                 !request->not_judged.empty() ? "NOT JUDGED: " + request->not_judged
                 : request->by == "rule" && request->anchors + request->panels == 0
                     ? "nothing in this building is of it"
                     : "yes");
  }
}

void write_facades(Markup& html, const DeviationT& deviation) {
  if (deviation.facades.empty()) return;
  static const std::map<std::string, const char*> sources = {{"rule", "a rule of yours"},
                                                             {"plate", "the azimuth of its plates"},
                                                             {"own_axes", "the axes of its elements"},
                                                             {"panel", "the plane of its panels"},
                                                             {"wall", "the wall or slab behind it"},
                                                             {"guess", "a guess"}};
  html.element("h3", "Which way the facades face");
  Scope wide(html, "div", {{"class", "wide"}});
  Scope table(html, "table");
  table_head(html, {left("Facade"), "Anchors", "Panels", left("Direction from"), left("Confirmed")});
  Scope body(html, "tbody");
  for (const auto& facade : deviation.facades) {
    Scope row(html, "tr");
    html.element("th", {{"scope", "row"}}, verbatim(facade->name));
    html.element("td", std::to_string(facade->anchors));
    html.element("td", std::to_string(facade->panels));
    const auto source = sources.find(facade->source);
    html.element("td", {{"class", "text"}}, source == sources.end() ? unknown : source->second);
    html.element("td", {{"class", "words"}}, facade->confirmed ? "yes" : "NO: " + facade->note);
  }
}

}  // namespace

void write_coverage(Markup& html, const DeviationT& deviation) {
  Scope part(html, "section", {{"id", "coverage"}});
  html.element("h2", "What was judged, and by what");
  write_shares(html, deviation);
  write_requests(html, deviation);
  write_facades(html, deviation);
}

}  // namespace plumbline::report

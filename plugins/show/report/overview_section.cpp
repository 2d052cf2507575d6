// How floors and facades stand: what passes, is undecided or fails of each.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "show/report/format.hpp"
#include "show/report/language.hpp"
#include "show/report/plot.hpp"
#include "show/report/sections.hpp"

namespace plumbline::report {

namespace {

/// Columns under one heading, each a verdict by its symbol, which takes no more room than a number: with a word in each
/// the table would be wider than a page.
struct VerdictGroup {
  const char* name;  ///< "Anchors"
  std::vector<ToleranceVerdict> verdicts;
};

constexpr ToleranceVerdict kAnchorVerdicts[] = {ToleranceVerdict::pass, ToleranceVerdict::undecided,
                                                ToleranceVerdict::fail, ToleranceVerdict::not_measured};

VerdictGroup verdict_group(const char* name, std::size_t verdicts) {
  return {name, {std::begin(kAnchorVerdicts), std::begin(kAnchorVerdicts) + verdicts}};
}

void verdict_head(Markup& html, const char* of, ToleranceVerdict verdict) {
  const std::string words = std::string(of) + " " + verdict_word(verdict);
  Scope th(html, "th", {{"scope", "col"}, {"aria-label", words}, {"title", words}});
  Scope badge(html, "span", {{"class", std::string("badge ") + verdict_class(verdict)}});
  Scope svg(html, "svg", {{"viewBox", "0 0 12 12"}, {"width", "12"}, {"height", "12"}, {"aria-hidden", "true"}});
  verdict_symbol(html, 6, 6.4, 4.8, verdict, false);
}

/// Two lines: groups over their verdicts, other columns over both.
void grouped_head(Markup& html, const std::vector<Cell>& before, const std::vector<VerdictGroup>& groups,
                  const std::vector<Cell>& after) {
  Scope head(html, "thead");
  const auto tall = [&](const Cell& cell) {
    html.element("th", {{"scope", "col"}, {"rowspan", "2"}, {"class", cell.left ? "text" : ""}}, cell.text);
  };
  {
    Scope row(html, "tr");
    for (const Cell& cell : before) tall(cell);
    for (const VerdictGroup& one : groups)
      html.element("th", {{"scope", "colgroup"}, {"class", "group"}, {"colspan", std::to_string(one.verdicts.size())}},
                   one.name);
    for (const Cell& cell : after) tall(cell);
  }
  Scope row(html, "tr");
  for (const VerdictGroup& one : groups)
    for (const ToleranceVerdict verdict : one.verdicts) verdict_head(html, one.name, verdict);
}

void write_verdict_key(Markup& html) {
  Scope key(html, "div", {{"class", "legend"}});
  for (const ToleranceVerdict verdict : kAnchorVerdicts) verdict_badge(html, verdict);
}

void write_floor_counts(Markup& html, const DeviationT& deviation) {
  const bool with_panels = !deviation.panels.empty();
  html.element("h3", "Floor by floor");
  Scope wide(html, "div", {{"class", "wide"}});
  Scope table(html, "table");
  std::vector<VerdictGroup> groups = {verdict_group("Anchors", 4)};
  if (with_panels) groups.push_back(verdict_group("Panels", 3));
  std::vector<Cell> after;
  if (deviation.surfaces) after = {"Surfaces open", "Surfaces fail"};
  after.push_back("All at once, at least");
  grouped_head(html, {"Floor", left("Storey"), left("Verdict")}, groups, after);
  Scope body(html, "tbody");
  for (auto floor = deviation.floors.rbegin(); floor != deviation.floors.rend(); ++floor) {
    const FloorDeviationT& f = **floor;
    Scope row(html, "tr");
    html.element("th", {{"scope", "row"}}, f.floor > 0 ? std::to_string(f.floor) : "unknown");
    html.element("td", {{"class", "text"}}, f.storey.empty() ? unknown : verbatim(f.storey));
    {
      Scope td(html, "td", {{"class", "text"}});
      verdict_badge(html, f.verdict);
    }
    for (const int n : {f.passed, f.undecided, f.failed, f.not_measured}) html.element("td", std::to_string(n));
    if (with_panels)
      for (const int n : {f.panels_passed, f.panels_undecided, f.panels_failed}) html.element("td", std::to_string(n));
    if (deviation.surfaces)
      for (const int n : {f.surfaces_open, f.surfaces_failed}) html.element("td", std::to_string(n));
    html.element("td", std::isfinite(f.pass_together) ? percent(f.pass_together) : std::string(unknown));
  }
}

/// Of a building of several facades.
void write_facade_counts(Markup& html, const DeviationT& deviation) {
  if (deviation.facades.size() < 2) return;
  std::map<std::string, std::array<int, 8>> counts;  // anchors, then panels: pass, undecided, fail, not measured
  const auto count = [&](const auto& element, std::size_t first) {
    const std::size_t at = element.verdict == ToleranceVerdict::pass        ? 0
                           : element.verdict == ToleranceVerdict::undecided ? 1
                           : element.verdict == ToleranceVerdict::fail      ? 2
                                                                            : 3;
    if (element.facade) ++counts[element.facade->facade][first + at];
  };
  for (const auto& anchor : deviation.anchors) count(*anchor, 0);
  for (const auto& panel : deviation.panels) count(*panel, 4);
  html.element("h3", "Facade by facade");
  Scope wide(html, "div", {{"class", "wide"}});
  Scope table(html, "table");
  grouped_head(html, {left("Facade")}, {verdict_group("Anchors", 4), verdict_group("Panels", 3)}, {});
  Scope body(html, "tbody");
  for (const auto& facade : deviation.facades) {
    Scope row(html, "tr");
    html.element("th", {{"scope", "row"}}, verbatim(facade->name));
    for (std::size_t k = 0; k < 7; ++k) html.element("td", std::to_string(counts[facade->name][k]));
  }
}

}  // namespace

void write_overview(Markup& html, const DeviationT& deviation) {
  write_floor_counts(html, deviation);
  write_facade_counts(html, deviation);
  write_verdict_key(html);
}

}  // namespace plumbline::report

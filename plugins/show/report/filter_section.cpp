// Search by name, facade, floor and verdict: of the rows of all tables those that are asked for.
#include <set>

#include "show/report/language.hpp"
#include "show/report/plot.hpp"
#include "show/report/sections.hpp"

namespace plumbline::report {

bool many(const DeviationT& deviation) { return deviation.anchors.size() + deviation.panels.size() > 600; }

std::string facade_of(const std::unique_ptr<FacadeFrameT>& frame) { return frame ? frame->facade : std::string(); }

PlacedRow::PlacedRow(Markup& html, int floor, const std::string& facade, ToleranceVerdict verdict)
    : row_(html, "tr",
           {{"data-floor", std::to_string(floor)}, {"data-facade", facade}, {"data-verdict", verdict_word(verdict)}}) {}

void write_filter(Markup& html, const DeviationT& deviation) {
  std::set<int> floors;
  for (const auto& floor : deviation.floors) floors.insert(floor->floor);
  // Thousands of rows are laid out only when they are asked for: without this they are, all of them, before the script
  // at the end of the page hides them (minutes for 20 000 rows).
  if (many(deviation)) html.open("script").raw("document.documentElement.classList.add(\"waiting\")").close();
  Scope bar(html, "div", {{"class", "slider filter"}, {"id", "filter"}, {"hidden", "hidden"}});
  html.element("label", {{"for", "filter-name"}}, "Find");
  html.empty("input", {{"id", "filter-name"}, {"type", "search"}, {"placeholder", "anchor or panel"}});
  const auto choice = [&](const char* id, const char* label,
                          const std::vector<std::pair<std::string, std::string>>& all) {
    html.element("label", {{"for", id}}, label);
    Scope select(html, "select", {{"id", id}});
    html.element("option", {{"value", ""}}, "all");
    for (const auto& [value, words] : all) html.element("option", {{"value", value}}, words);
  };
  std::vector<std::pair<std::string, std::string>> facades, levels, verdicts;
  for (const auto& facade : deviation.facades) facades.emplace_back(facade->name, verbatim(facade->name));
  for (const int floor : floors)
    levels.emplace_back(std::to_string(floor), floor > 0 ? std::to_string(floor) : "unknown");
  for (const auto verdict :
       {ToleranceVerdict::fail, ToleranceVerdict::undecided, ToleranceVerdict::not_measured, ToleranceVerdict::pass})
    verdicts.emplace_back(verdict_word(verdict), verdict_word(verdict));
  if (facades.size() > 1) choice("filter-facade", "Facade", facades);
  choice("filter-floor", "Floor", levels);
  choice("filter-verdict", "Verdict", verdicts);
  html.element("output", {{"id", "filter-count"}, {"for", "filter-name"}}, "");
}

}  // namespace plumbline::report

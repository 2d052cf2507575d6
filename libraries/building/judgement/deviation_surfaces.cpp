// Surfaces in the judgement of the whole, and what doubts and misfits of the measurement do to them.
#include <cmath>
#include <map>

#include "building/judgement/surfaces.hpp"

namespace plumbline::judgement {
namespace {

/// Floors of panels by GlobalId, and by name where one panel has it.
std::map<std::string, int> floors_of_panels(const DeviationT& deviation) {
  std::map<std::string, int> floors, bearers;
  for (const auto& panel : deviation.panels) ++bearers[panel->name];
  for (const auto& panel : deviation.panels) {
    floors[panel->guid] = panel->floor;
    if (bearers[panel->name] == 1) floors[panel->name] = panel->floor;
  }
  return floors;
}

/// The row of a panel's storey, if one of its anchors has been judged there; null without.
FloorDeviationT* row_of_storey(const std::string& panel, const PanelStoreys& storeys, DeviationT& deviation) {
  const auto storey = storeys.storey_of.find(panel);
  if (storey == storeys.storey_of.end() || storey->second.empty()) return nullptr;
  for (auto& row : deviation.floors)
    if (row->storey_guid == storey->second) return row.get();
  return nullptr;
}

/// What lies on no floor that is known (of a storey without anchors, a joint between panels that share a name) is told.
void take_into_floors(const SurfaceJudgementT& surfaces, const PanelStoreys& storeys, DeviationT& deviation) {
  const std::map<std::string, int> floors = floors_of_panels(deviation);
  int nowhere = 0;
  std::map<std::string, int> without_anchors;  // by the name of the storey
  for (const auto& verdict : surfaces.verdicts) {
    if (verdict->verdict == ToleranceVerdict::pass) continue;
    FloorDeviationT* counts_in = nullptr;
    const auto floor = floors.find(verdict->guid.empty() ? verdict->panel : verdict->guid);
    if (floor == floors.end()) counts_in = row_of_storey(verdict->guid, storeys, deviation);
    for (auto& row : deviation.floors)
      if (floor != floors.end() && row->floor == floor->second) counts_in = row.get();
    if (counts_in) {
      ++(verdict->verdict == ToleranceVerdict::fail ? counts_in->surfaces_failed : counts_in->surfaces_open);
      continue;
    }
    const auto storey = storeys.storey_of.find(verdict->guid);
    const auto name = storeys.names.find(storey == storeys.storey_of.end() ? "" : storey->second);
    ++(name == storeys.names.end() ? nowhere : without_anchors[name->second]);
  }
  for (const auto& [name, count] : without_anchors)
    deviation.warnings.push_back(std::to_string(count) +
                                 " verdicts of surfaces and joints that do not pass are of storey " + name +
                                 ", of which no anchor is judged: they count in no floor. The verdict of the whole "
                                 "counts them.");
  if (nowhere > 0)
    deviation.warnings.push_back(std::to_string(nowhere) +
                                 " verdicts of surfaces and joints that do not pass count in no floor: nobody says "
                                 "which floor their panels are on. The verdict of the whole counts them.");
  for (auto& row : deviation.floors) {
    if (row->surfaces_failed > 0)
      row->verdict = ToleranceVerdict::fail;
    else if (row->surfaces_open > 0 && row->verdict == ToleranceVerdict::pass)
      row->verdict = ToleranceVerdict::undecided;
  }
}

}  // namespace

void leave_open(SurfaceJudgementT& judgement) {
  for (auto& verdict : judgement.verdicts)
    if (verdict->verdict == ToleranceVerdict::pass || verdict->verdict == ToleranceVerdict::fail)
      verdict->verdict = ToleranceVerdict::undecided, verdict->probability = std::nan("");
  judgement.undecided += judgement.passed + judgement.failed;
  judgement.passed = judgement.failed = 0;
}

PanelStoreys panel_storeys(const DesignT& design) {
  PanelStoreys storeys;
  for (const auto& element : design.elements)
    if (element->is_panel) storeys.storey_of[element->guid] = element->storey_guid;
  for (const auto& storey : design.storeys) storeys.names[storey->guid] = storey->name;
  return storeys;
}

void take_surfaces(SurfaceJudgementT surfaces, DeviationT& deviation, const PanelStoreys& storeys) {
  if (!deviation.doubts.empty()) leave_open(surfaces);
  for (const auto& request : surfaces.requests) {
    auto copy = std::make_unique<JudgementRequestT>();
    copy->asked = "surfaces, " + request->asked, copy->by = request->by, copy->panels = request->panels;
    copy->not_judged = request->not_judged;
    deviation.not_judged += !request->not_judged.empty();
    deviation.requests.push_back(std::move(copy));
  }
  take_into_floors(surfaces, storeys, deviation);
  const bool open = surfaces.undecided + surfaces.not_judged + deviation.not_judged > 0;
  if (surfaces.failed > 0)
    deviation.verdict = ToleranceVerdict::fail;
  else if (open && deviation.verdict == ToleranceVerdict::pass)
    deviation.verdict = ToleranceVerdict::undecided;
  deviation.surfaces = std::make_unique<SurfaceJudgementT>(std::move(surfaces));
}

}  // namespace plumbline::judgement

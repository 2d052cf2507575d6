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

/// What lies on no floor that is known (a panel without anchors, a joint between panels that share a name) is told.
void take_into_floors(const SurfaceJudgementT& surfaces, DeviationT& deviation) {
  const std::map<std::string, int> floors = floors_of_panels(deviation);
  int nowhere = 0;
  for (const auto& verdict : surfaces.verdicts) {
    if (verdict->verdict == ToleranceVerdict::pass) continue;
    const auto floor = floors.find(verdict->guid.empty() ? verdict->panel : verdict->guid);
    if (floor == floors.end()) {
      ++nowhere;
      continue;
    }
    for (auto& row : deviation.floors)
      if (row->floor == floor->second)
        ++(verdict->verdict == ToleranceVerdict::fail ? row->surfaces_failed : row->surfaces_open);
  }
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

void take_surfaces(SurfaceJudgementT surfaces, DeviationT& deviation) {
  if (!deviation.doubts.empty()) leave_open(surfaces);
  for (const auto& request : surfaces.requests) {
    auto copy = std::make_unique<JudgementRequestT>();
    copy->asked = "surfaces, " + request->asked, copy->by = request->by, copy->panels = request->panels;
    copy->not_judged = request->not_judged;
    deviation.not_judged += !request->not_judged.empty();
    deviation.requests.push_back(std::move(copy));
  }
  take_into_floors(surfaces, deviation);
  const bool open = surfaces.undecided + surfaces.not_judged + deviation.not_judged > 0;
  if (surfaces.failed > 0)
    deviation.verdict = ToleranceVerdict::fail;
  else if (open && deviation.verdict == ToleranceVerdict::pass)
    deviation.verdict = ToleranceVerdict::undecided;
  deviation.surfaces = std::make_unique<SurfaceJudgementT>(std::move(surfaces));
}

}  // namespace plumbline::judgement

#include "loop/gate/plan_gates.hpp"

#include <algorithm>
#include <map>
#include <stdexcept>

#include "base/text/words.hpp"
#include "loop/gate/gate.hpp"

namespace plumbline::loop {
namespace {

using Decision = std::pair<GateDecision, std::string>;

/// What no rule makes GO: the plan holds it whatever its probability, because something is open, or it cannot tell how
/// probable it is.
bool is_open(const InstallationPlanT& plan, const PlannedPanelT& panel) {
  const bool told = panel.p_in >= 0, held = panel.gate == GateDecision::hold;
  // A plan that does not say what stands in the way may hold a panel for it.
  const bool hindered = panel.obstacle == PanelObstacle::not_said ? held : panel.obstacle != PanelObstacle::none;
  return !plan.doubts.empty() || !told || hindered || (held && panel.p_in >= plan.go_probability);
}

/// `decide`: of a panel, its decision and why.
template <typename Decide>
void decide_all(InstallationPlanT& plan, const Decide& decide) {
  plan.go = plan.hold = plan.no_go = 0;
  for (auto& panel : plan.panels) {
    Decision decision = plan.doubts.empty() ? decide(*panel) : Decision{panel->gate, panel->reason};
    if (decision.first == GateDecision::go && is_open(plan, *panel)) decision = {GateDecision::hold, panel->reason};
    if (decision.first != panel->gate) panel->reason = decision.second;
    panel->gate = decision.first;
    if (panel->installed) continue;  // counted are panels that are still to be hung
    (panel->gate == GateDecision::go ? plan.go : panel->gate == GateDecision::hold ? plan.hold : plan.no_go)++;
  }
}

std::string of_limits(const PlannedLengthT& length, double k) {
  return length.name + ": " + text::millimetres(length.value) + ", limits " + text::millimetres(length.low) + " and " +
         text::millimetres(length.high) + ", k u " + text::millimetres(k * length.u);
}

}  // namespace

void gate_by_probability(InstallationPlanT& plan, double go, double no_go) {
  const double least = go > 0 ? go : plan.go_probability, most = no_go > 0 ? no_go : plan.go_probability;
  decide_all(plan, [&](const PlannedPanelT& panel) -> Decision {
    if (!(panel.p_in >= 0)) return {panel.gate, panel.reason};
    if (panel.p_in >= least) return {GateDecision::go, panel.reason};
    return {1 - panel.p_in >= most ? GateDecision::no_go : GateDecision::hold, panel.reason};
  });
}

void gate_by_guard_band(InstallationPlanT& plan, double k) {
  if (!(k >= 0))
    throw std::runtime_error("the factor of the guard band is " + std::to_string(k) + ", expected 0 or more");
  std::map<std::string, const PlannedPanelT*> panels;
  for (const auto& panel : plan.panels) panels[panel->id] = panel.get();
  std::map<std::string, std::vector<const PlannedLengthT*>> lengths;
  for (const auto& length : plan.lengths) {
    const bool all_hang = std::all_of(length->panels.begin(), length->panels.end(), [&](const std::string& id) {
      const auto found = panels.find(id);
      return found != panels.end() && found->second->installed;
    });
    for (const std::string& id : length->panels)
      if (const auto found = panels.find(id); found != panels.end() && (!found->second->installed || all_hang))
        lengths[id].push_back(length.get());
  }
  decide_all(plan, [&](const PlannedPanelT& panel) -> Decision {
    const PlannedLengthT* doubtful = nullptr;
    for (const PlannedLengthT* length : lengths[panel.id]) {
      const double guard = k * length->u;
      if (length->value < length->low - guard || length->value > length->high + guard)
        return {GateDecision::no_go, "outside by its guard band: " + of_limits(*length, k)};
      // A length that is not told is not within.
      if (!(length->value >= length->low + guard && length->value <= length->high - guard) && !doubtful)
        doubtful = length;
    }
    if (doubtful) return {GateDecision::hold, "within its guard band: " + of_limits(*doubtful, k)};
    if (lengths[panel.id].empty()) return {GateDecision::hold, panel.reason};
    return {GateDecision::go, "all its lengths keep their guard bands"};
  });
}

}  // namespace plumbline::loop

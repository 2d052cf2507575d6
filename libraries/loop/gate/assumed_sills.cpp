#include "loop/gate/assumed_sills.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "base/text/words.hpp"

namespace plumbline::loop {
namespace {

/// Factor of the standard deviation that somebody takes a sill to be in place by, for what if it is not.
constexpr double kFartherOff = 2;

bool is_on_assumed_sill(const Panel& panel) {
  return panel.below && panel.below->panel < 0 && panel.below->sills.empty();
}

/// The joint on it is as good as it was.
void move_farther_off(Support& below) {
  const double joint = std::sqrt(std::max(0.0, below.sigma * below.sigma - below.sill_sigma * below.sill_sigma));
  below.sill_sigma *= kFartherOff;
  below.sigma = std::hypot(joint, below.sill_sigma);
}

std::string in_place(const Panel& panel) {
  return "in place to " + text::millimetres(panel.below->sigma) + ", its joint included";
}

}  // namespace

void doubt_assumed_sills(const Facade& facade, const Fit& fit, const GateOptions& options,
                         std::vector<PanelGate>& gates) {
  if (std::none_of(facade.panels.begin(), facade.panels.end(), is_on_assumed_sill)) return;
  Facade farther = facade;
  for (Panel& panel : farther.panels)
    if (is_on_assumed_sill(panel)) move_farther_off(*panel.below);
  const std::vector<PanelGate> without = judge_plan(farther, fit, options);
  for (std::size_t j = 0; j < gates.size(); ++j) {
    PanelGate& gate = gates[j];
    const Panel& panel = facade.panels[j];
    if (gate.verdict != GateVerdict::go) continue;
    if (without[j].verdict != GateVerdict::go) {
      gate.verdict = GateVerdict::hold, gate.obstacle = Obstacle::assumed_sill;
      gate.reason = fmt::format(
          "the sill below {} was not measured, and that it is in place decides: were it twice as far off as is assumed "
          "(sill_sigma of held_below), p would be {:.3f}; measure places of it and name them with 'sills'; {}",
          is_on_assumed_sill(panel) ? "it" : "what it stands on", without[j].p_in, gate.reason);
    } else if (is_on_assumed_sill(panel)) {
      gate.reason += "; the sill below it was not measured: it is assumed to be " + in_place(panel);
    }
  }
}

std::string assumed_sill_words(const Facade& facade) {
  std::vector<std::string> panels;
  const Panel* worst = nullptr;
  for (const Panel& panel : facade.panels)
    if (is_on_assumed_sill(panel)) {
      panels.push_back(panel.id);
      if (!worst || panel.below->sigma > worst->below->sigma) worst = &panel;
    }
  if (!worst) return {};
  return "the sill below " + text::join(panels, 4) + " was not measured: that it is " + in_place(*worst) +
         ", is assumed (sill_sigma of held_below)" + "; " + "'sills' names measured places of it";
}

}  // namespace plumbline::loop

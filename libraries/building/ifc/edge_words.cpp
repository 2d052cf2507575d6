#include "building/ifc/edge_words.hpp"

#include "base/text/words.hpp"

namespace plumbline::ifc {

std::string edge_words(const InstallationPlanT& plan) {
  std::vector<std::string> panels;
  for (const auto& panel : plan.panels)
    if (!panel->sills.empty()) panels.push_back(panel->id);
  if (panels.empty()) return {};
  return "Of the bottom edges that a sill holds (" + text::join(panels, 4) +
         ") the plan follows the middle: how far its ends are off beside that, a sill out of line, is in no setting "
         "and no probability; the judgement has it as warp, and a panel that does not pass there is HOLD.";
}

}  // namespace plumbline::ifc

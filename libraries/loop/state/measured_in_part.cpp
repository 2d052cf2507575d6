#include "loop/state/measured_in_part.hpp"

#include <algorithm>
#include <set>

#include "base/text/words.hpp"

namespace plumbline::loop {

std::vector<std::string> measured_in_part(const InstallationPlanT& plan, const LoopStateT& state) {
  std::set<std::string> measured, hanging, of_whole;
  for (const auto& bracket : plan.brackets)
    if (bracket->measured.allFinite()) measured.insert(bracket->id);
  for (const auto& item : state.items)
    if (item->kind == "panel" && item->hangs) hanging.insert(item->id);
  const auto is_measured = [&](const std::string& id) { return measured.contains(id); };
  for (const auto& panel : plan.panels)
    if (std::all_of(panel->brackets.begin(), panel->brackets.end(), is_measured))
      of_whole.insert(panel->brackets.begin(), panel->brackets.end());
  std::vector<std::string> found;
  for (const auto& panel : plan.panels) {
    if (panel->installed || hanging.contains(panel->id)) continue;
    std::vector<std::string> missing;
    bool is_begun = false;
    for (const std::string& id : panel->brackets)
      if (!is_measured(id))
        missing.push_back(id);
      else
        is_begun = is_begun || !of_whole.contains(id);
    if (is_begun && !missing.empty()) found.push_back(panel->id + " without " + text::join(missing, 8));
  }
  return found;
}

}  // namespace plumbline::loop

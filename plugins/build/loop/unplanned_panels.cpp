#include "build/loop/unplanned_panels.hpp"

#include <algorithm>

#include "geometry/panel_fit.hpp"

namespace plumbline::loop {

UnmeasuredDesign::UnmeasuredDesign(const DesignT& design, const std::vector<Bracket>& brackets,
                                   const std::vector<std::string>& guids) {
  std::map<std::string, std::string> storey_of;  // of anchors, by GlobalId
  for (const auto& element : design.elements)
    if (element->is_anchor) anchors_.push_back(element->position), storey_of[element->guid] = element->storey_guid;
  for (std::size_t b = 0; b < brackets.size(); ++b) {
    anchors_.push_back(brackets[b].design);
    if (const auto storey = storey_of.find(guids[b]);
        brackets[b].floor > 0 && storey != storey_of.end() && !storey->second.empty())
      floor_.try_emplace(storey->second, brackets[b].floor);
  }
  // A basement that the anchors do not count moves all of the design's own numbers.
  int first = 0;
  for (const auto& storey : design.storeys)
    if (const auto known = floor_.find(storey->guid); known != floor_.end()) {
      first = known->second - storey->floor;
      break;
    }
  for (const auto& storey : design.storeys) floor_.try_emplace(storey->guid, std::max(0, storey->floor + first));
}

int UnmeasuredDesign::floor_of(const DesignElementT& panel) const {
  const auto known = floor_.find(panel.storey_guid);
  return known == floor_.end() ? 0 : known->second;
}

bool UnmeasuredDesign::has_anchor(const DesignElementT& panel) const {
  if (!panel.anchor_guids.empty()) return true;
  if (!panel.box_low.allFinite() || !panel.box_high.allFinite()) return true;  // nothing says that it has none
  const auto panel_from_frame = panel.placement.inverse();
  return std::any_of(anchors_.begin(), anchors_.end(), [&](const Eigen::Vector3d& anchor) {
    return distance_from_box(panel.box_low, panel.box_high, panel_from_frame * anchor) <= kPanelReach;
  });
}

std::string UnmeasuredDesign::why_not_planned(const DesignElementT& panel) const {
  return has_anchor(panel) ? "not one anchor there was measured: measure them, then run again"
                           : "no anchor is there, in the design or as a plate: mend the design, or name it in "
                             "plan.with.standing if it hangs";
}

}  // namespace plumbline::loop

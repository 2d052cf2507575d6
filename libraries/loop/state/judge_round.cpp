// What was done, by a new measurement: brackets where they were to be set, panels within their limits.
#include <algorithm>
#include <cmath>

#include "base/text/words.hpp"
#include "loop/state/round.hpp"

namespace plumbline::loop {

bool Round::may_do_again(LoopItemT& item, const Because& because) {
  move(state_, item, ItemStatus::rework, because);
  if (++item.reworks <= options_.most_reworks) return true;
  move(state_, item, ItemStatus::rejected,
       by_plan("after " + std::to_string(options_.most_reworks) + " reworks: " + because.why,
               ItemReason::reworked_too_often));
  return false;
}

void Round::do_again(LoopItemT& item, const Because& because) {
  if (!may_do_again(item, because)) return;
  move(state_, item, ItemStatus::planned, by_plan("to be planned again: " + because.why));
}

void Round::verify_brackets() {
  find_floors_that_moved();
  doubt_what_stands_on_moved_control();
  for (const auto& bracket : plan_.brackets) {
    LoopItemT& item = *this->item("bracket", bracket->id);
    if (moved_floors_.count(item.floor) || !bracket->measured.allFinite()) continue;
    // What was done is not judged by what was measured before.
    const bool waits = item.status == ItemStatus::executed || item.status == ItemStatus::relocalised;
    if (waits && !is_measured_anew(item, *bracket, options_.measured_at)) {
      stay(item, "waits for a measurement that was made after it was done" +
                     std::string(item.at.empty() && !options_.measured_at.empty() ? "; its report has no date" : ""));
      continue;
    }
    const bool is_known = item.expected.allFinite(), was_planned = item.status == ItemStatus::planned;
    // Nor does it say where something is that was worked on since: the next campaign does, and starts anew there.
    if (!is_known && was_planned && !bracket->basis.empty() && !is_measured_anew(item, *bracket, options_.measured_at))
      continue;
    if (is_known)
      judge_bracket(item, *bracket);
    else
      look_again(item, *bracket);
    if (item.unset.empty()) note_unset(item, *bracket);
    // What nobody touched keeps the place that it is judged by: small movements would add up unseen.
    if (item.status == ItemStatus::rejected || (item.status == ItemStatus::planned && !(is_known && was_planned)))
      item.expected = bracket->measured;
  }
}

void Round::judge_bracket(LoopItemT& item, const BracketSettingT& bracket) {
  const Eigen::Vector3d shift = bracket.measured - place_of(item, bracket);
  const double off = shift.cwiseAbs().maxCoeff(), most = doubt(bracket).maxCoeff();
  const bool is_there = (shift.cwiseAbs().array() <= doubt(bracket).array()).all();
  if (item.status == ItemStatus::executed)
    judge_setting(item, bracket, off, is_there);
  else if (!is_there)
    give_to_a_person(item, "moved by " + text::millimetres(off) +
                               " without a report that was taken: look whether the bracket was moved or its plate was "
                               "knocked");
  else if (item.status == ItemStatus::relocalised)
    verify(item, bracket, "within " + text::millimetres(most));
}

void Round::verify(LoopItemT& item, const BracketSettingT& bracket, const std::string& why) {
  // What it has used of its range is what was measured, not what was asked.
  const Eigen::Vector3d off = along_axes(bracket, bracket.measured - place_of(item, bracket));
  if (off.allFinite()) item.setting += off;
  move(state_, item, ItemStatus::verified, by_plan(why));
  item.expected = bracket.measured, item.pending.setZero();
}

void Round::note_unset(LoopItemT& item, const BracketSettingT& bracket) {
  Eigen::Vector3d unset = bracket.measured;
  for (int k = 0; k < 3; ++k) unset -= item.setting[k] * bracket.axes[k];
  item.unset.assign(unset.begin(), unset.end());
}

void Round::look_again(LoopItemT& item, const BracketSettingT& bracket) {
  Eigen::Matrix3d axes;
  axes << bracket.axes[0], bracket.axes[1], bracket.axes[2];
  item.setting = setting_of(item, bracket.measured, axes);
  if (item.status == ItemStatus::executed)
    move(state_, item, ItemStatus::relocalised, by_plan("measured on control that was looked at"));
  if (item.status != ItemStatus::relocalised) return;
  if (carries(item.id)) {
    verify(item, bracket, "carries a panel, which is judged by where this bracket is now");
    return;
  }
  const Because because = by_plan("to be planned on control that was looked at");
  item.pending.setZero();
  move(state_, item, ItemStatus::rework, because), move(state_, item, ItemStatus::planned, because);
}

void Round::judge_setting(LoopItemT& item, const BracketSettingT& bracket, double off, bool is_there) {
  const double most = doubt(bracket).maxCoeff();
  move(state_, item, ItemStatus::relocalised,
       by_plan("measured " + text::millimetres(off) + " from where it was to be"));
  const std::string how = is_there ? "" : explanation(item, bracket, most);
  if (is_there) {
    verify(item, bracket, "within " + text::millimetres(most));
    return;
  }
  // If that is so, what was reported is not what was done.
  if (!how.empty()) item.setting += along_axes(bracket, bracket.measured - place_of(item, bracket));
  give_to_a_person(item, "stands " + text::millimetres(off) + " from where it was to be set, " +
                             (how.empty() ? "and no mistake of a robot explains it: look whether the bracket slipped "
                                            "or its plate was knocked"
                                          : "as if " + how + ": look whether that is so, or its plate was knocked"));
}

void Round::give_to_a_person(LoopItemT& item, const std::string& why) {
  const Because because = by_plan(why, ItemReason::look);
  reject_item(state_, item, because);
  reject_what_stands_on(state_, item, because);
  for (const auto& panel : plan_.panels)
    if (std::find(panel->brackets.begin(), panel->brackets.end(), item.id) != panel->brackets.end())
      if (LoopItemT& hung = *this->item("panel", panel->id); hung.status != ItemStatus::planned)
        reject_item(state_, hung, by_plan("its bracket " + item.id + " " + because.why, because.reason));
}

bool Round::can_be_judged(const PlannedPanelT& panel, const LoopItemT& item) const {
  return std::all_of(panel.brackets.begin(), panel.brackets.end(), [&](const std::string& id) {
    const BracketSettingT& bracket = *bracket_of_.at(id);
    return bracket.measured.allFinite() &&
           (item.status != ItemStatus::executed || is_measured_anew(item, bracket, options_.measured_at));
  });
}

/// A plate that was knocked before it was measured first moves its bracket's place, and no campaign on the plates tells
/// it: the panel itself does. A test of each axis by kOff standard deviations, and its minimal detectable bias (Baarda
/// 1968) at a power of 80 %.
std::string Round::place_contradiction(const PlannedPanelT& panel, LoopItemT& item) const {
  constexpr double kOff = 4, kPower = 0.8416;
  if (item.place.size() != 6) return {};
  // A large sigma makes a place no better than none at all would.
  const std::string coarse = coarse_contradiction(panel, item);
  if (!(item.place[3] > 0) || !coarse.empty()) {
    item.place.clear();
    return coarse;
  }
  if (panel.centre_sigma.size() != 3) return {};
  double worst = 0, off = 0;
  for (int k = 0; k < 3; ++k) {
    const double sigma = std::hypot(item.place[3 + k], panel.centre_sigma[k]);
    const double apart = std::abs(item.place[k] - panel.centre[k] - panel.shift[k]);
    if (apart > worst * sigma) worst = apart / sigma, off = apart;
    item.told_from = std::fmax(item.told_from, (kOff + kPower) * sigma);
  }
  item.place.clear();
  if (worst <= kOff) return {};
  return "was measured " + text::millimetres(off) +
         " from where its brackets say that it hangs: look whether the plate of one of them was knocked before it was "
         "measured first, or the panel does not sit in its hooks";
}

/// A number without its precision contradicts nothing but that the panel is within its limits, and that from so far on
/// as a tape or an unmeasured tool may be off. Nor does one whose precision is worse than a tape's, but that what its
/// sigma explains is none: beyond three of it is one sound panel in 120 (the worst of three axes).
std::string Round::coarse_contradiction(const PlannedPanelT& panel, const LoopItemT& item) const {
  constexpr double kCoarse = 0.020, kExplained = 3;
  double limit = 0, off = 0;
  for (const auto& length : plan_.lengths)
    if (length->quantity == "corner" && length->panels.size() == 1 && length->panels[0] == panel.id)
      for (const double side : {length->low, length->high})
        if (std::isfinite(side)) limit = std::fmax(limit, std::abs(side));
  for (int k = 0; k < 3; ++k) off = std::fmax(off, std::abs(item.place[k] - panel.centre[k] - panel.shift[k]));
  const double sigma = *std::max_element(item.place.begin() + 3, item.place.end());
  if (!(limit > 0) || off <= std::fmax(limit + kCoarse, kExplained * sigma)) return {};
  return "was reported " + text::millimetres(off) +
         " from where its brackets say that it hangs, more than its limits of " + text::millimetres(limit) +
         " and the " + text::millimetres(kCoarse) +
         (item.place[3] > 0 ? " that a place may be off by, and more than three times its sigma"
                            : " that a place without sigma may be off by") +
         ": look where it hangs, or whether that is another panel's place";
}

void Round::verify_panels() {
  for (const auto& panel : plan_.panels) {
    LoopItemT& item = *this->item("panel", panel->id);
    if (!panel->installed || !(panel->p_in >= 0) || touches_moved_floor(*panel) || !can_be_judged(*panel, item))
      continue;
    const Because because = by_plan(panel->reason);
    if (item.status == ItemStatus::executed) move(state_, item, ItemStatus::relocalised, because);
    if (const std::string why = place_contradiction(*panel, item); !why.empty()) {
      reject_item(state_, item, by_plan(why, ItemReason::measured_elsewhere));
      continue;
    }
    const bool is_right = panel->gate == GateDecision::go && panel->p_in >= options_.verified;
    if (item.status == ItemStatus::verified && !is_right)
      move(state_, item, ItemStatus::relocalised, by_plan("no longer sure to hang right: " + panel->reason));
    if (item.status == ItemStatus::rework && is_right)
      move(state_, item, ItemStatus::relocalised, by_plan("hangs within its limits again: " + panel->reason));
    if (item.status != ItemStatus::relocalised) continue;
    if (is_right && !item.seen)
      stay(item,
           "would hang right, and nothing has seen it hang: give its measured place, or accept it when somebody "
           "has seen it");
    else if (is_right)
      move(state_, item, ItemStatus::verified, because);
    else if (1 - panel->p_in >= options_.verified)
      may_do_again(item, by_plan("hangs outside its limits: " + panel->reason));
  }
}

}  // namespace plumbline::loop

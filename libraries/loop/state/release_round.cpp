// What comes next: what was released and no longer holds is recalled, what is GO and whose turn it is is released.
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/text/words.hpp"
#include "loop/state/round.hpp"

namespace plumbline::loop {
namespace {

/// A bracket that is asked to move by less than this is left as it is [m].
constexpr double kDeadBand = 0.0003;
/// A panel that is more likely inside than this is measured once more before its brackets are set once more.
constexpr double kLikely = 0.5;
/// What many campaigns would give must be above what is asked for by so much, and so many are enough: the last
/// hundredth is bought by many rounds.
constexpr double kClear = 0.01;
constexpr int kMostCampaigns = 10;
/// So many rounds in a row nothing but another campaign is waited for; then somebody decides.
constexpr int kMostWaits = 10;

/// Setting a bracket again measures no other one, and adds no hook.
bool says_nothing_of_its_brackets(const PlannedPanelT& panel) {
  return panel.obstacle == PanelObstacle::not_measured ||
         (panel.gate == GateDecision::hold && panel.obstacle != PanelObstacle::none &&
          panel.obstacle != PanelObstacle::not_said);
}

/// Panels whose last line in a journal says may_not_hang.
std::set<std::string> told_not_to_hang(const std::vector<std::string>& journal) {
  std::set<std::string> panels;
  for (const std::string& text : journal) {
    const auto line = nlohmann::json::parse(text, nullptr, false);
    if (!line.is_object() || line.value("kind", "") != "panel") continue;
    if (line.contains("reported_revision") || line.contains("answered_revision")) continue;
    const std::string panel = line.value("item", "");
    if (line.value("reason", "") == EnumNameItemReason(ItemReason::may_not_hang))
      panels.insert(panel);
    else
      panels.erase(panel);
  }
  return panels;
}

}  // namespace

int Round::revision() {
  if (!raised_) ++state_.revision, raised_ = true;
  return state_.revision;
}

bool Round::another_campaign_may_do(const PlannedPanelT& panel) const {
  if (panel.gate != GateDecision::hold || !(panel.p_in_repeated >= options_.verified + kClear)) return false;
  if (std::all_of(panel.brackets.begin(), panel.brackets.end(),
                  [&](const std::string& id) { return bracket_of_.at(id)->campaigns >= kMostCampaigns; }))
    return false;
  const bool is_set = std::any_of(panel.brackets.begin(), panel.brackets.end(), [&](const std::string& id) {
    return item("bracket", id)->status == ItemStatus::verified && !carries(id);
  });
  return !is_set || panel.p_in >= kLikely;
}

void Round::find_stale_brackets() {
  for (const auto& bracket : plan_.brackets) {
    LoopItemT& item = *this->item("bracket", bracket->id);
    if (item.status != ItemStatus::released || moved_floors_.count(item.floor) || !bracket->measured.allFinite())
      continue;
    const Eigen::Vector3d moved = along_axes(*bracket, bracket->measured - item.expected);
    const double change = (moved + bracket->setting - item.pending).cwiseAbs().maxCoeff();
    if (change <= 0.1 * options_.setting_tolerance) continue;
    recall_item(item, "stale: the new measurement asks for " + text::millimetres(change) + " elsewhere");
    item.expected = bracket->measured;
  }
}

void Round::find_stale_panels() {
  for (const auto& panel : plan_.panels)
    if (LoopItemT& item = *this->item("panel", panel->id); item.status == ItemStatus::released) {
      const std::string why = why_stale(*panel, item);
      if (!why.empty()) recall_item(item, "stale: " + why);
    }
}

std::string Round::why_stale(const PlannedPanelT& panel, const LoopItemT& item) const {
  if (panel.gate != GateDecision::go) return "it is no longer GO: " + panel.reason;
  if (touches_moved_floor(panel)) return "the control of its floor or of one beside it moved";
  if (const LoopItemT* sill = sill_for_a_person(state_, panel.id)) return "its sill " + sill->id + " is for a person";
  for (const std::string& id : panel.depends_on) {
    const LoopItemT* before = this->item("panel", id);
    if (before && (may_not_hang(*before) || sill_for_a_person(state_, id)))
      return id + ", which is to hang before it, is for a person";
    if (before && before->status == ItemStatus::rework) return id + ", which is to hang before it, is to be taken down";
    if (before && !hangs(*before)) return id + ", which is to hang before it, does not hang";
  }
  for (const std::string& id : panel.brackets)
    if (this->item("bracket", id)->status != ItemStatus::verified && !carries(id))
      return "its bracket " + id + " is no longer verified";
  if (const std::string other = neighbour_to_take_down(panel); !other.empty())
    return other + ", which shares a bracket with it, is to be taken down";
  const double change = (panel.centre + panel.shift - item.expected).cwiseAbs().maxCoeff();
  return change > 0.1 * options_.setting_tolerance ? "it is to hang " + text::millimetres(change) + " elsewhere"
                                                   : std::string();
}

void Round::unset_what_does_not_do() {
  for (const auto& panel : plan_.panels) {
    LoopItemT& hung = *item("panel", panel->id);
    if (hung.status != ItemStatus::planned || panel->gate == GateDecision::go || touches_moved_floor(*panel)) continue;
    if (says_nothing_of_its_brackets(*panel)) continue;
    if (sill_for_a_person(state_, panel->id)) continue;  // by a sill that may be moved back nothing is set anew
    if (another_campaign_may_do(*panel)) {
      // The same campaign once more is none that it waited for.
      if (has_its_turn(*panel) && plan_.basis != state_.basis && ++hung.waited > kMostWaits) {
        reject_item(state_, hung,
                    by_plan("waited for " + std::to_string(kMostWaits) +
                            " campaigns more, and none decided it: measure it more precisely, or have its brackets set "
                            "by hand, then accept it; " +
                            panel->reason));
        continue;
      }
      measured_again_.insert(panel->id);
      state_.to_measure = state_.to_measure || has_its_turn(*panel);
      continue;
    }
    if (panel->gate == GateDecision::hold && !panel->measure.empty() && plan_.basis == state_.basis) continue;
    for (const std::string& id : panel->brackets) {
      LoopItemT* bracket = item("bracket", id);
      if (bracket && bracket->status == ItemStatus::verified && !carries(id))
        do_again(*bracket, by_plan("panel " + panel->id + " would not hang right on it: " + panel->reason));
    }
  }
}

Waiting Round::before_its_turn(const PlannedPanelT& panel) const {
  for (const std::string& id : panel.depends_on) {
    const LoopItemT* before = item("panel", id);
    const std::string waits = "waits for " + id + ", which is to hang before it";
    if (!before) return {waits + " and is not planned"};
    if (before->status == ItemStatus::rejected) return {waits + " and is for a person"};
    if (before->status == ItemStatus::rework) return {waits + " and is to be taken down", ItemReason::waits_for_panel};
    if (before->status != ItemStatus::verified) return {waits, ItemReason::waits_for_panel};
  }
  return {};
}

std::string Round::neighbour_that_waits(const PlannedPanelT& panel) const {
  for (const auto& other : plan_.panels) {
    if (other->id == panel.id || measured_again_.count(other->id) == 0 || !has_its_turn(*other)) continue;
    for (const std::string& id : other->brackets)
      if (!carries(id) && std::count(panel.brackets.begin(), panel.brackets.end(), id) > 0) return other->id;
  }
  return {};
}

std::string Round::neighbour_to_take_down(const PlannedPanelT& panel) const {
  for (const auto& other : plan_.panels) {
    if (other->id == panel.id || item("panel", other->id)->status != ItemStatus::rework) continue;
    for (const std::string& id : other->brackets)
      if (std::count(panel.brackets.begin(), panel.brackets.end(), id) > 0) return other->id;
  }
  return {};
}

Waiting Round::why_not_yet(const PlannedPanelT& panel) const {
  if (const LoopItemT* sill = sill_for_a_person(state_, panel.id))
    return {"waits for its sill: " + sill->id + " is for a person"};
  if (panel.brackets.empty() && panel.obstacle == PanelObstacle::no_bracket)
    return {panel.reason, ItemReason::not_planned};
  if (measured_again_.count(panel.id) > 0) return {"waits for another campaign: " + panel.reason};
  if (panel.gate != GateDecision::go) return {panel.reason.empty() ? "is not GO" : panel.reason};
  if (touches_moved_floor(panel)) return {"waits for control: that of its floor or of one beside it moved"};
  if (const std::string other = neighbour_to_take_down(panel); !other.empty())
    return {"waits for " + other + ", which shares a bracket with it and is to be taken down",
            ItemReason::waits_for_panel};
  return before_its_turn(panel);
}

void Round::note_may_not_hang(const PlannedPanelT& panel, LoopItemT& item) {
  if (panel.gate == GateDecision::go || (panel.gate == GateDecision::hold && panel.by_hand.empty())) return;
  if (!may_not_hang_) may_not_hang_ = told_not_to_hang(state_.journal);
  if (!may_not_hang_->insert(panel.id).second) return;
  const std::string why = item.why;
  const ItemReason reason = item.reason;
  note(state_, item, by_plan("may not be hung so: " + panel.reason, ItemReason::may_not_hang));
  stay(item, why, reason);
}

Because Round::released(const std::string& why) const {
  Because because = by_plan(why);
  because.at = options_.at;  // reports on it that are older are refused
  return because;
}

void Round::release() {
  for (const auto& panel : plan_.panels) {
    LoopItemT& item = *this->item("panel", panel->id);
    if (item.status != ItemStatus::planned) continue;
    if (const Waiting waiting = why_not_yet(*panel); !waiting.why.empty()) {
      stay(item, waiting.why, waiting.reason);
      note_may_not_hang(*panel, item);
      continue;
    }
    bool ready = true;
    for (const std::string& id : panel->brackets) ready = bracket_is_ready(id) && ready;
    if (!ready) {
      stay(item, "waits for its brackets", ItemReason::waits_for_brackets);
      continue;
    }
    if (const std::string other = neighbour_that_waits(*panel); !other.empty()) {
      stay(item, "waits for " + other + ", which shares a bracket with it and waits for another campaign");
      continue;
    }
    item.waited = 0;
    item.revision = revision(), item.expected = panel->centre + panel->shift, item.jobs.clear(), item.seen = false;
    item.place.clear(), item.told_from = std::nan("");
    move(state_, item, ItemStatus::released, released(panel->reason));
  }
}

bool Round::bracket_is_ready(const std::string& id) {
  LoopItemT& item = *this->item("bracket", id);
  const BracketSettingT& bracket = *bracket_of_.at(id);
  if (item.status == ItemStatus::verified) return true;
  if (item.status != ItemStatus::planned || !bracket.measured.allFinite()) return false;
  if (carries(id)) return true;
  // The plan took it as it stood and says nothing on how it is to be set.
  if (bracket.fixed) return false;
  item.expected = bracket.measured;
  if (bracket.setting.cwiseAbs().maxCoeff() < kDeadBand) {
    move(state_, item, ItemStatus::verified, by_plan("needs no setting"));
    return true;
  }
  item.pending = bracket.setting, item.revision = revision(), item.jobs.clear();
  move(state_, item, ItemStatus::released, released("gate of its panels is GO"));
  return false;
}

}  // namespace plumbline::loop

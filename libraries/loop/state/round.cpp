// A new plan on a new measurement: what was done is judged, what is in doubt is no longer verified, what is GO is
// released.
#include <algorithm>
#include <map>
#include <set>
#include <stdexcept>

#include "loop/fit/facade.hpp"
#include "loop/state/bracket_places.hpp"
#include "loop/state/date.hpp"
#include "loop/state/floor_moves.hpp"
#include "loop/state/machine.hpp"
#include "loop/state/transitions.hpp"

namespace plumbline::loop {
namespace {

/// A bracket that is asked to move by less than this is left as it is [m].
constexpr double kDeadBand = 0.0003;

/// Back to planned with one more rework, or rejected after too many.
void do_again(LoopStateT& state, LoopItemT& item, const MachineOptions& options, const Because& because) {
  move(state, item, ItemStatus::rework, because);
  if (++item.reworks > options.most_reworks) {
    move(state, item, ItemStatus::rejected,
         {"after " + std::to_string(options.most_reworks) + " reworks: " + because.why, {}, {}, because.rests_on});
    return;
  }
  move(state, item, ItemStatus::planned, {"to be planned again: " + because.why, {}, {}, because.rests_on});
}

class Round {
 public:
  Round(LoopStateT& state, const InstallationPlanT& plan, const MachineOptions& options)
      : state_(state), plan_(plan), options_(options) {
    add_items(state, plan);
    for (auto& item : state_.items) item_of_[item->kind + " " + item->id] = item.get();
    for (const auto& bracket : plan_.brackets) bracket_of_[bracket->id] = bracket.get();
    rests_on_ = {plan_.basis};
  }

  void run() {
    moved_floors_ = floors_in_doubt();
    state_.to_plan = false;
    if (const std::string why = doubt_of_everything(); !why.empty()) {
      hold_everything(why);
    } else {
      verify_brackets();
      verify_panels();
      find_stale();
      unset_what_does_not_do();
      release();
      for (const auto& bracket : plan_.brackets)
        if (bracket->fixed && item("bracket", bracket->id)->status == ItemStatus::planned && !carries(bracket->id))
          state_.to_plan = true;
      // What was reported is judged by measurements that no plan has seen before.
      for (auto& item : state_.items)
        if (item->status != ItemStatus::executed) note_basis(*item);
    }
    state_.basis = plan_.basis;
  }

 private:
  LoopItemT* item(const std::string& kind, const std::string& id) const {
    const auto found = item_of_.find(kind + " " + id);
    return found == item_of_.end() ? nullptr : found->second;
  }

  /// Why nothing can be told by this plan; empty: something can.
  std::string doubt_of_everything() const {
    if (const std::string name = control_without_floor(state_); !name.empty())
      return name + " moved, and nobody knows what hangs on it: look at it, then accept it";
    return plan_.doubts.empty() ? std::string() : "the measurement is in doubt: " + plan_.doubts.front();
  }

  /// Nothing is verified, done again or released; what waits to be judged says why.
  void hold_everything(const std::string& why) {
    for (auto& item : state_.items) {
      if (item->status == ItemStatus::released) recall_item(*item, why);
      if (item->status != ItemStatus::verified && item->status != ItemStatus::rejected) item->why = why;
    }
  }

  void recall_item(LoopItemT& item, const std::string& why) {
    const Because because{why, {}, {}, rests_on_};
    move(state_, item, ItemStatus::stale, because), move(state_, item, ItemStatus::planned, because);
    item.pending.setZero();
  }

  /// The measurements that an item rests on: of its anchor, or of the anchors of its panel.
  void note_basis(LoopItemT& item) const {
    if (item.kind == "bracket") {
      const auto bracket = bracket_of_.find(item.id);
      if (bracket != bracket_of_.end() && !bracket->second->basis.empty()) item.basis = bracket->second->basis;
      return;
    }
    for (const auto& panel : plan_.panels) {
      if (panel->id != item.id) continue;
      item.basis.clear();
      for (const std::string& id : panel->brackets) item.basis += this->item("bracket", id)->basis + " ";
    }
  }

  /// Without a new measurement a floor that moved stays in doubt.
  std::set<int> floors_in_doubt() const {
    std::set<int> floors;
    for (const auto& item : state_.items)
      if (std::count(state_.moved_control.begin(), state_.moved_control.end(), control_of_floor(item->floor)) > 0)
        floors.insert(item->floor);
    return floors;
  }

  void verify_brackets() {
    find_floors_that_moved();
    doubt_what_stands_on_moved_control();
    for (const auto& bracket : plan_.brackets) {
      LoopItemT& item = *this->item("bracket", bracket->id);
      if (moved_floors_.count(item.floor) || !bracket->measured.allFinite()) continue;
      // What was done is not judged by what was measured before.
      const bool waits = item.status == ItemStatus::executed || item.status == ItemStatus::relocalised;
      if (waits && !is_measured_anew(item, *bracket, options_.measured_at)) {
        item.why = "waits for a measurement that was made after it was done" +
                   std::string(item.at.empty() && !options_.measured_at.empty() ? "; its report has no date" : "");
        continue;
      }
      const bool is_known = item.expected.allFinite(), was_planned = item.status == ItemStatus::planned;
      if (is_known)
        judge_bracket(item, *bracket);
      else
        look_again(item, *bracket);
      // What nobody touched keeps the place that it is judged by: small movements would add up unseen.
      if (item.status == ItemStatus::rejected || (item.status == ItemStatus::planned && !(is_known && was_planned)))
        item.expected = bracket->measured;
    }
  }

  void judge_bracket(LoopItemT& item, const BracketSettingT& bracket) {
    const Eigen::Vector3d shift = bracket.measured - place_of(item, bracket);
    const double off = shift.cwiseAbs().maxCoeff(), most = doubt(bracket).maxCoeff();
    const bool is_there = (shift.cwiseAbs().array() <= doubt(bracket).array()).all();
    if (item.status == ItemStatus::executed)
      judge_setting(item, bracket, off, is_there);
    else if (!is_there)
      give_to_a_person(item,
                       "moved by " + millimetres(off) +
                           " without a report that was taken: look whether the bracket was moved or its plate was "
                           "knocked");
    else if (item.status == ItemStatus::relocalised)
      verify(item, bracket, "within " + millimetres(most));
  }

  void verify(LoopItemT& item, const BracketSettingT& bracket, const std::string& why) {
    // What it has used of its range is what was measured, not what was asked.
    const Eigen::Vector3d off = along_axes(bracket, bracket.measured - place_of(item, bracket));
    if (off.allFinite()) item.setting += off;
    move(state_, item, ItemStatus::verified, {why, {}, {}, rests_on_});
    item.expected = bracket.measured, item.pending.setZero();
  }

  /// Measured for the first time, or for the first time since its control was found to be in order again: what carries
  /// a panel is where it is now, what was being set is planned anew.
  void look_again(LoopItemT& item, const BracketSettingT& bracket) {
    if (item.status == ItemStatus::executed)
      move(state_, item, ItemStatus::relocalised, {"measured on control that was looked at", {}, {}, rests_on_});
    if (item.status != ItemStatus::relocalised) return;
    if (carries(item.id)) {
      verify(item, bracket, "carries a panel, which is judged by where this bracket is now");
      return;
    }
    const Because because{"to be planned on control that was looked at", {}, {}, rests_on_};
    item.pending.setZero();
    move(state_, item, ItemStatus::rework, because), move(state_, item, ItemStatus::planned, because);
  }

  Eigen::Vector3d doubt(const BracketSettingT& bracket) const { return doubt_of(bracket, options_.setting_tolerance); }

  /// A measurement of the plate does not tell a bracket that was set elsewhere from a plate that was knocked, also
  /// where a known mistake of a robot would explain its place.
  void judge_setting(LoopItemT& item, const BracketSettingT& bracket, double off, bool is_there) {
    const double most = doubt(bracket).maxCoeff();
    move(state_, item, ItemStatus::relocalised,
         {"measured " + millimetres(off) + " from where it was to be", {}, {}, rests_on_});
    const std::string how = is_there ? "" : explanation(item, bracket, most);
    if (is_there) {
      verify(item, bracket, "within " + millimetres(most));
      return;
    }
    // If that is so, what was reported is not what was done.
    if (!how.empty()) item.setting += along_axes(bracket, bracket.measured - place_of(item, bracket));
    give_to_a_person(item, "stands " + millimetres(off) + " from where it was to be set, " +
                               (how.empty() ? "and no mistake of a robot explains it: look whether the bracket slipped "
                                              "or its plate was knocked"
                                            : "as if " + how + ": look whether that is so, or its plate was knocked"));
  }

  void give_to_a_person(LoopItemT& item, const std::string& why) {
    const Because because{why, {}, {}, rests_on_};
    reject_item(state_, item, because);
    for (const auto& panel : plan_.panels)
      if (std::find(panel->brackets.begin(), panel->brackets.end(), item.id) != panel->brackets.end())
        if (LoopItemT& hung = *this->item("panel", panel->id); hung.status != ItemStatus::planned)
          reject_item(state_, hung, {"its bracket " + item.id + " " + because.why, {}, {}, rests_on_});
  }

  /// Floors whose anchors all moved together: their control did, now or when they were measured last. Nothing of them
  /// is verified or released by this plan. Fewer than three anchors do not show that it is in order again.
  void find_floors_that_moved() {
    for (const auto& [number, floor] :
         moves_of_floors(state_, plan_, options_.setting_tolerance, options_.measured_at)) {
      const bool moved = floor.moved();
      if (!moved && floor.moves.size() < 3) continue;
      auto& names = state_.moved_control;
      names.erase(std::remove(names.begin(), names.end(), control_of_floor(number)), names.end());
      if (moved) names.push_back(control_of_floor(number));
    }
    moved_floors_ = floors_in_doubt();
  }

  /// What was released is recalled, and what was verified is measured at most: it was verified by one of two
  /// measurements that contradict each other.
  void doubt_what_stands_on_moved_control() {
    for (auto& item : state_.items) {
      if (!moved_floors_.count(item->floor)) continue;
      const Because because{"the anchors of floor " + std::to_string(item->floor) +
                                " moved together since they were measured last: check their control",
                            {},
                            {},
                            rests_on_};
      if (item->status == ItemStatus::released)
        recall_item(*item, because.why);
      else if (item->status == ItemStatus::verified)
        move(state_, *item, ItemStatus::relocalised, because);
    }
  }

  /// Whether a panel hangs on it.
  bool carries(const std::string& bracket) const {
    for (const auto& panel : plan_.panels) {
      const LoopItemT& hung = *item("panel", panel->id);
      if (!hung.hangs && hung.status != ItemStatus::executed && hung.status != ItemStatus::relocalised &&
          hung.status != ItemStatus::verified)
        continue;
      if (std::find(panel->brackets.begin(), panel->brackets.end(), bracket) != panel->brackets.end()) return true;
    }
    return false;
  }

  /// Whether all anchors of a panel were measured, and those of a panel that was just hung since it hangs.
  bool can_be_judged(const PlannedPanelT& panel, const LoopItemT& item) const {
    return std::all_of(panel.brackets.begin(), panel.brackets.end(), [&](const std::string& id) {
      const BracketSettingT& bracket = *bracket_of_.at(id);
      return bracket.measured.allFinite() &&
             (item.status != ItemStatus::executed || is_measured_anew(item, bracket, options_.measured_at));
    });
  }

  void verify_panels() {
    for (const auto& panel : plan_.panels) {
      LoopItemT& item = *this->item("panel", panel->id);
      if (!panel->installed || !(panel->p_in >= 0) || touches_moved_floor(*panel) || !can_be_judged(*panel, item))
        continue;
      const Because because{panel->reason, {}, {}, rests_on_};
      if (item.status == ItemStatus::executed) move(state_, item, ItemStatus::relocalised, because);
      const bool is_right = panel->gate == GateDecision::go && panel->p_in >= options_.verified;
      if (item.status == ItemStatus::verified && !is_right)
        move(state_, item, ItemStatus::relocalised,
             {"no longer sure to hang right: " + panel->reason, {}, {}, rests_on_});
      if (item.status != ItemStatus::relocalised) continue;
      if (is_right && !item.seen)
        item.why =
            "would hang right, and nothing has seen it hang: give its measured place, or accept it when somebody "
            "has seen it";
      else if (is_right)
        move(state_, item, ItemStatus::verified, because);
      else if (1 - panel->p_in >= options_.verified)
        take_down(*panel, item);
    }
  }

  /// Its own floor or that of a neighbour above or below, whose control moved.
  bool touches_moved_floor(const PlannedPanelT& panel) const {
    return moved_floors_.count(panel.floor) + moved_floors_.count(panel.floor - 1) +
               moved_floors_.count(panel.floor + 1) >
           0;
  }

  void take_down(const PlannedPanelT& panel, LoopItemT& item) {
    do_again(state_, item, options_, {"hangs outside its limits: " + panel.reason, {}, {}, rests_on_});
    // What was done again too often is left to a person, and hangs.
    item.hangs = item.status == ItemStatus::rejected, item.seen = item.seen && item.hangs;
    for (const std::string& id : panel.brackets) {
      LoopItemT* bracket = this->item("bracket", id);
      if (bracket && bracket->status == ItemStatus::verified && !carries(id))
        do_again(state_, *bracket, options_, {"panel " + panel.id + " is taken down", {}, {}, rests_on_});
    }
  }

  void find_stale() {
    for (const auto& bracket : plan_.brackets) {
      LoopItemT& item = *this->item("bracket", bracket->id);
      if (item.status != ItemStatus::released || moved_floors_.count(item.floor) || !bracket->measured.allFinite())
        continue;
      const Eigen::Vector3d moved = along_axes(*bracket, bracket->measured - item.expected);
      const double change = (moved + bracket->setting - item.pending).cwiseAbs().maxCoeff();
      if (change <= 0.1 * options_.setting_tolerance) continue;
      recall_item(item, "stale: the new measurement asks for " + millimetres(change) + " elsewhere");
      item.expected = bracket->measured;
    }
    for (const auto& panel : plan_.panels)
      if (LoopItemT& item = *this->item("panel", panel->id); item.status == ItemStatus::released) {
        const std::string why = why_stale(*panel, item);
        if (!why.empty()) recall_item(item, "stale: " + why);
      }
  }

  /// Why a panel may not be hung as it was released; empty: it may.
  std::string why_stale(const PlannedPanelT& panel, const LoopItemT& item) const {
    if (panel.gate != GateDecision::go) return "it is no longer GO: " + panel.reason;
    if (touches_moved_floor(panel)) return "the control of its floor or of one beside it moved";
    for (const std::string& id : panel.brackets)
      if (this->item("bracket", id)->status != ItemStatus::verified && !carries(id))
        return "its bracket " + id + " is no longer verified";
    const double change = (panel.centre + panel.shift - item.expected).cwiseAbs().maxCoeff();
    return change > 0.1 * options_.setting_tolerance ? "it is to hang " + millimetres(change) + " elsewhere"
                                                     : std::string();
  }

  /// Brackets that stand where they were to be, under a panel that is not GO with them: set again, if the plan could
  /// tell how.
  void unset_what_does_not_do() {
    for (const auto& panel : plan_.panels) {
      const LoopItemT& hung = *item("panel", panel->id);
      if (hung.status != ItemStatus::planned || panel->gate == GateDecision::go || touches_moved_floor(*panel))
        continue;
      if (panel->gate == GateDecision::hold && !panel->measure.empty() && plan_.basis == state_.basis) continue;
      for (const std::string& id : panel->brackets) {
        LoopItemT* bracket = item("bracket", id);
        if (bracket && bracket->status == ItemStatus::verified && !carries(id))
          do_again(state_, *bracket, options_,
                   {"panel " + panel->id + " would not hang right on it: " + panel->reason, {}, {}, rests_on_});
      }
    }
  }

  bool turn_of(const PlannedPanelT& panel) const {
    return std::all_of(panel.depends_on.begin(), panel.depends_on.end(), [&](const std::string& id) {
      const LoopItemT* before = item("panel", id);
      return !before || before->status == ItemStatus::verified ||
             (before->status == ItemStatus::rejected && !before->hangs);
    });
  }

  void release() {
    bool raised = false;
    const auto revision = [&] {
      if (!raised) ++state_.revision, raised = true;
      return state_.revision;
    };
    for (const auto& panel : plan_.panels) {
      LoopItemT& item = *this->item("panel", panel->id);
      if (item.status != ItemStatus::planned || panel->gate != GateDecision::go || !turn_of(*panel) ||
          touches_moved_floor(*panel)) {
        if (item.status == ItemStatus::planned)
          item.why = panel->gate == GateDecision::go ? "waits for panels before it" : panel->reason;
        continue;
      }
      bool ready = true;
      for (const std::string& id : panel->brackets) ready = bracket_is_ready(id, revision) && ready;
      if (!ready) {
        item.why = "waits for its brackets";
        continue;
      }
      item.revision = revision(), item.expected = panel->centre + panel->shift, item.jobs.clear(), item.seen = false;
      move(state_, item, ItemStatus::released, {panel->reason, {}, options_.at, rests_on_});
    }
  }

  template <typename Revision>
  bool bracket_is_ready(const std::string& id, const Revision& revision) {
    LoopItemT& item = *this->item("bracket", id);
    const BracketSettingT& bracket = *bracket_of_.at(id);
    if (item.status == ItemStatus::verified) return true;
    if (item.status != ItemStatus::planned || !bracket.measured.allFinite()) return false;
    if (carries(id)) return true;
    // The plan took it as it stood and says nothing on how it is to be set.
    if (bracket.fixed) return false;
    item.expected = bracket.measured;
    if (bracket.setting.cwiseAbs().maxCoeff() < kDeadBand) {
      move(state_, item, ItemStatus::verified, {"needs no setting", {}, {}, rests_on_});
      return true;
    }
    item.pending = bracket.setting, item.revision = revision(), item.jobs.clear();
    move(state_, item, ItemStatus::released, {"gate of its panels is GO", {}, options_.at, rests_on_});
    return false;
  }

  LoopStateT& state_;
  const InstallationPlanT& plan_;
  const MachineOptions& options_;
  std::map<std::string, LoopItemT*> item_of_;
  std::map<std::string, const BracketSettingT*> bracket_of_;
  std::vector<std::string> rests_on_;
  std::set<int> moved_floors_;
};

}  // namespace

void apply_plan(LoopStateT& state, const InstallationPlanT& plan, const MachineOptions& options) {
  const std::optional<double> measured = seconds_of(options.measured_at), now = seconds_of(options.at);
  if (measured && now && *measured > *now)
    throw std::runtime_error("the measurement began at " + options.measured_at + ", after the plan that rests on it (" +
                             options.at + "): are the two exchanged, or in another zone?");
  Round(state, plan, options).run();
}

}  // namespace plumbline::loop

// One round of the state machine: what apply_plan() does, in the order of run().
#pragma once

#include <map>
#include <optional>
#include <set>

#include "loop/state/bracket_places.hpp"
#include "loop/state/machine.hpp"
#include "loop/state/transitions.hpp"

namespace plumbline::loop {

/// Why a panel waits, in words and for programs; without words: it does not.
struct Waiting {
  std::string why;
  ItemReason reason = ItemReason::other;
};

class Round {
 public:
  Round(LoopStateT& state, const InstallationPlanT& plan, const MachineOptions& options);
  void run();

 private:
  LoopItemT* item(const std::string& kind, const std::string& id) const;
  /// What follows from this plan and its measurement.
  Because by_plan(std::string why, ItemReason reason = ItemReason::other) const;
  /// Why nothing can be told by this plan; empty: something can.
  std::string doubt_of_everything() const;
  /// Nothing is verified, done again or released; what waits to be judged says why.
  void hold_everything(const std::string& why);
  /// Control that has other coordinates than for the campaigns before: where everything was measured, it is no more.
  /// Likewise of single items, where steps that are each too small add up since they were released or verified.
  void take_control();
  /// What this campaign read is known from now on.
  void take_readings();
  void recall_item(LoopItemT& item, const std::string& why);
  /// The measurements that an item rests on: of its anchor, or of the anchors of its panel.
  void note_basis(LoopItemT& item) const;
  /// What places of a sill hold. One that was not measured, or that somebody is to look at, holds what it held before.
  void note_sills();
  /// What the design does not have any more is no work: released, it is recalled.
  void note_gone();
  /// Of brackets that no panel of the plan hangs on, why nothing is set on them.
  void tell_unused();
  /// Without a new measurement a floor that moved stays in doubt.
  std::set<int> floors_in_doubt() const;
  /// Floors whose anchors all moved together: their control did, now or when they were measured last. Nothing of them
  /// is verified or released by this plan. Fewer than three anchors do not show that it is in order again.
  void find_floors_that_moved();
  /// What was released is recalled, and what was verified is measured at most: it was verified by one of two
  /// measurements that contradict each other.
  void doubt_what_stands_on_moved_control();
  /// Its own floor or that of a neighbour above or below, whose control moved.
  bool touches_moved_floor(const PlannedPanelT& panel) const;
  /// Whether it was reported as hung, and not taken down since.
  static bool hangs(const LoopItemT& panel);
  /// Whether a panel hangs on it.
  bool carries(const std::string& bracket) const;

  // What was done, by this measurement (judge_round.cpp).
  void verify_brackets();
  void judge_bracket(LoopItemT& item, const BracketSettingT& bracket);
  void verify(LoopItemT& item, const BracketSettingT& bracket, const std::string& why);
  /// Measured for the first time, or for the first time since its control was found to be in order again: what carries
  /// a panel is where it is now, what was being set is planned anew.
  void look_again(LoopItemT& item, const BracketSettingT& bracket);
  /// Where its anchor would be without what it was set by: told once, before anything can have gone wrong with it.
  void note_unset(LoopItemT& item, const BracketSettingT& bracket);
  /// A measurement of the plate does not tell a bracket that was set elsewhere from a plate that was knocked, also
  /// where a known mistake of a robot would explain its place.
  void judge_setting(LoopItemT& item, const BracketSettingT& bracket, double off, bool is_there);
  void give_to_a_person(LoopItemT& item, const std::string& why);
  /// Whether all anchors of a panel were measured, and those of a panel that was just hung since it hangs.
  bool can_be_judged(const PlannedPanelT& panel, const LoopItemT& item) const;
  void verify_panels();
  /// Why the panel's own place contradicts its brackets; empty: it does not, or there is none. It is compared once: the
  /// building moves afterwards.
  std::string place_contradiction(const PlannedPanelT& panel, LoopItemT& item) const;
  std::string coarse_contradiction(const PlannedPanelT& panel, const LoopItemT& item) const;
  /// One rework more; after too many it is rejected, and false.
  bool may_do_again(LoopItemT& item, const Because& because);
  /// Back to planned with one more rework, or rejected after too many.
  void do_again(LoopItemT& item, const Because& because);
  Eigen::Vector3d doubt(const BracketSettingT& bracket) const { return doubt_of(bracket, options_.setting_tolerance); }

  // What comes next (release_round.cpp).
  void find_stale_brackets();
  /// Also after brackets were taken back: a job has no panel on a bracket that is to be set again.
  void find_stale_panels();
  /// Why a panel may not be hung as it was released; empty: it may.
  std::string why_stale(const PlannedPanelT& panel, const LoopItemT& item) const;
  /// Brackets that stand where they were to be, under a panel that is not GO with them: set again, if the plan could
  /// tell how.
  void unset_what_does_not_do();
  /// The first panel that is to hang before this one and does not, verified, with what is to be said of it; empty:
  /// none.
  Waiting before_its_turn(const PlannedPanelT& panel) const;
  /// A panel beside this one, on one of its brackets, that is to be taken down: with it the bracket may move. Empty:
  /// none.
  std::string neighbour_to_take_down(const PlannedPanelT& panel) const;
  bool has_its_turn(const PlannedPanelT& panel) const { return before_its_turn(panel).why.empty(); }
  /// Why a panel that is planned is not released yet, whatever its brackets; empty: nothing stands in the way.
  Waiting why_not_yet(const PlannedPanelT& panel) const;
  /// The panel beside it that waits for another campaign: hung now, it would fix a bracket of both that the other one
  /// may need elsewhere. Empty: none.
  std::string neighbour_that_waits(const PlannedPanelT& panel) const;
  void release();
  /// In the journal, once, of a panel that turned NO_GO or before which something is to be done by hand: who was told
  /// of it reads there that it is over, too.
  void note_may_not_hang(const PlannedPanelT& panel, LoopItemT& item);
  Because released(const std::string& why) const;
  bool bracket_is_ready(const std::string& id);
  /// Whether a panel that is HOLD is likely to be GO as it is planned, once more campaigns leave no error of their own.
  /// Brackets that were set for it are left where they are only if it is more likely inside than not.
  bool another_campaign_may_do(const PlannedPanelT& panel) const;
  /// Of this plan: raised once, by the first item that it releases.
  int revision();

  LoopStateT& state_;
  const InstallationPlanT& plan_;
  const MachineOptions& options_;
  std::map<std::string, LoopItemT*> item_of_;
  std::map<std::string, const BracketSettingT*> bracket_of_;
  std::vector<std::string> rests_on_;
  std::set<int> moved_floors_;
  std::set<std::string> measured_again_;  ///< panels that wait for another campaign
  /// Panels whose last line in the journal says may_not_hang; filled when it is asked for.
  std::optional<std::set<std::string>> may_not_hang_;
  bool raised_ = false;
};

}  // namespace plumbline::loop

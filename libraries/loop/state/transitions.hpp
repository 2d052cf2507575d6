// What the parts of the state machine share: one change with its line in the journal.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "loop/state/machine.hpp"

namespace plumbline::loop {

/// Who says in the journal what follows from a measurement or a plan.
inline constexpr const char* kProgram = "plumbline";

/// Why an item changes.
struct Because {
  std::string why;                        ///< in words
  std::string by, at;                     ///< who worked on it and when (ISO 8601); empty: nobody, or it is not said
  std::vector<std::string> rests_on;      ///< hashes
  ItemReason reason = ItemReason::other;  ///< for programs
  std::string told_by = kProgram;         ///< of a change that is no work: who says so
  std::string told_at;                    ///< and when; empty: not said
};

/// Of what a person says: it rests on the measurement of the round before, which that person had when looking.
Because told(const LoopStateT& state, const Teller& teller, std::string why);

/// Changes the status and writes it into the journal. Throws std::logic_error for what may not follow.
void move(LoopStateT& state, LoopItemT& item, ItemStatus to, const Because& because);

/// A line in the journal about an item that stays where it stands.
void note(LoopStateT& state, LoopItemT& item, const Because& because);

/// A line in the journal about an order of a release before: the item stays as it is, and why it stands there, too.
/// `reported`, `answered`: JournalEntry::reported_revision and answered_revision.
void note_recalled_order(LoopStateT& state, const LoopItemT& item, const Because& because, int reported, int answered);

/// Why an item stands where it does, without a line in the journal: what each round says anew.
inline void stay(LoopItemT& item, std::string why, ItemReason reason = ItemReason::other) {
  item.why = std::move(why), item.reason = reason;
}

/// To a person, from wherever it stands; the journal has each step on the way.
void reject_item(LoopStateT& state, LoopItemT& item, const Because& because);

/// A panel that hung and does not any more: planned again, with nothing left of where it was.
void unhang(LoopStateT& state, LoopItemT& panel, const Because& because);

/// To a person what rests on a place of a sill that moved, or may have: the panels whose bottom edge it holds, but for
/// those that are only planned, which wait (sill_for_a_person()).
void reject_what_stands_on(LoopStateT& state, const LoopItemT& sill, const Because& because);

/// The place of a sill that somebody is to look at and that holds this panel's bottom edge; null: none.
const LoopItemT* sill_for_a_person(const LoopStateT& state, const std::string& panel);

/// Name of a floor's control in LoopState::moved_control: "control of floor 3".
std::string control_of_floor(int floor);

/// The first name in LoopState::moved_control that is no floor's: a point whose floor nobody knows. Empty: none.
std::string control_without_floor(const LoopStateT& state);

}  // namespace plumbline::loop

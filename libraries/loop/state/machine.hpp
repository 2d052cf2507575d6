// The states of brackets and panels, and what moves them: reports, measurements, plans, a control network that changed.
//
//   planned -> released -> executing -> executed -> relocalised -> verified | rework | rejected
//
// A bracket is executed when it was set, relocalised when its anchor was measured again, verified when it stands where
// it was to be set. A panel is released when its brackets are verified and its gate is GO, verified when the
// measurement of its hooks says that it hangs within its limits. Rework goes back to planned, a given number of times.
// A bracket that carries a hanging panel stays as it is. A panel that hangs outside its limits is rework, and hangs,
// until somebody says that it was taken down: nobody else knows.
//
// A plate is measured, not the bracket. One that stands elsewhere than it should is looked at by a person, also where a
// mistake of a robot (not moved, moved the other way, twice) would explain it: a plate that was knocked meanwhile may
// look the same, and would be set wrong and measured right. Where the anchors of a floor moved together, nothing of it
// stays verified until its control fits again or somebody has looked at it.
//
// The plates tell nothing of whether a panel hangs: it is verified only if it was itself measured (its report has a
// place that is not the target's own number) or a person has seen it. A place with standard deviations is compared with
// where the brackets say that the panel hangs; one that contradicts them sends a person.
#pragma once

#include "artifacts/actuals.hpp"
#include "artifacts/installation_plan.hpp"
#include "artifacts/loop_state.hpp"
#include "loop/state/journal.hpp"

namespace plumbline::loop {

const char* name_of(ItemStatus status);  ///< "PLANNED", "RELEASED", ...
bool may_follow(ItemStatus from, ItemStatus to);

struct MachineOptions {
  int most_reworks = 3;
  /// Of a bracket against where it was to be set, each direction [m]: what is farther off was not done as asked. What
  /// is less is judged by what it does to the panel, because plans rest on the bracket as it was measured. At least
  /// four standard deviations.
  double setting_tolerance = 0.003;
  double verified = 0.95;  ///< least p_in of a hanging panel that is verified, and of 1 - p_in for its rework
  std::string at;          ///< when the plan is applied, ISO 8601 with zone; empty: not said. Older reports are refused
  /// When the measurement under the plan began, likewise: what was done later, or nobody knows when, is not judged by
  /// it. Empty: not said, and only a measurement that is another than before tells.
  std::string measured_at;
};

/// Applies reports, those of one item in the order of their dates (report_order.hpp). Each that is not taken comes back
/// with its reason: unknown item, another revision than the item was released with, another job, an item that is not
/// released, a report not later than its release or the report before, or with a date that is none, a panel's without
/// revision, job and date, one that came before (told, and harmless), a setting far from what was asked for, a place
/// metres away from where the item is (with what would explain it: feet, millimetres, exchanged axes, another frame), a
/// name of a bracket and a panel, standard deviations that are in another unit or none, a date later than `now` (ISO
/// 8601 with zone; empty: not said, and nothing is too late). "removed" says that a panel does not hang any more: it is
/// planned again. One that was reported done and later failed goes to a person. What ends an order that was recalled is
/// refused, and the journal has it (recalled_orders.hpp). `doubted`: panels' reports that are
/// taken, and do not show that it hangs, with why.
std::vector<std::string> apply_actuals(LoopStateT& state, const ActualsT& actuals,
                                       std::vector<std::string>* doubted = nullptr, const std::string& now = {});

/// Takes the words of reports that were refused, "staked.csv:7: why", into the state, as of the round that is made.
void note_refused(LoopStateT& state, const std::vector<std::string>& refused);

/// Why a round cannot be at `now` (ISO 8601 with zone): something was released after it. Empty: it can.
std::string time_doubt(const LoopStateT& state, const std::string& now);

/// Takes a new plan, made from a new measurement: items of a first plan are added; brackets and panels that were
/// executed are judged by it; released ones whose setting changed by more than a tenth of the tolerance, or all of them
/// when `plan.basis` is another and no measurement explains it, become stale and are planned again; panels that are GO
/// and whose turn it is are released with the brackets that carry them. What was reported is judged once the anchor's
/// own measurement (BracketSetting::basis) is another than before. Throws std::runtime_error for a name whose GlobalId
/// changed.
void apply_plan(LoopStateT& state, const InstallationPlanT& plan, const MachineOptions& options);

/// Who says something that no report and no measurement says, and when (ISO 8601 with zone; empty: not said).
struct Teller {
  std::string by = "a person", at = {};
};

/// Everything released becomes stale: control has another adjustment, or points of it moved.
void recall(LoopStateT& state, const std::vector<std::string>& moved_control, const std::string& why,
            const Teller& teller = {});

/// A rejected item that a person has looked at: planned again, as it is measured next. "control of floor 3" of
/// LoopState::moved_control: its next measurement is the reference for the floor. Any other name in there ("CP3")
/// blocks everything until it is accepted. A panel that hangs is to be measured again. A panel that hangs by its report
/// alone: a person has seen it. False if it is none of these.
bool accept_item(LoopStateT& state, const std::string& id, const Teller& teller = {});

/// Whether nobody knows if it hangs, so that to have looked at it does not say what was found: given to a person, and
/// seen by nothing.
bool may_not_hang(const LoopItemT& item);

/// accept_item() of what a person looked at after this state's last round: "F01-C02-R1@4" of round 4, as next_words()
/// asks for it. A name alone, or of another round, accepts nothing: left in a command it would accept what nobody has
/// looked at. Of a panel that may not hang the word is "F01-P02 hangs@4". Why nothing is accepted; empty: it is.
std::string accept_look(LoopStateT& state, const std::string& word, const Teller& teller = {});

/// "F01-P02@4", in the same way: a panel that somebody took down after this state's last round, or found not hanging.
/// Why nothing changes; empty: it is planned again.
std::string remove_look(LoopStateT& state, const std::string& word, const Teller& teller = {});

/// "F01-C02-R1@4": what accept_look() and remove_look() take after this state's last round.
std::string look_word(const LoopStateT& state, const std::string& name);

/// "F01-P02 hangs@4".
std::string hangs_word(const LoopStateT& state, const std::string& name);

/// Counts, `done`, `next`.
void close_round(LoopStateT& state);

}  // namespace plumbline::loop

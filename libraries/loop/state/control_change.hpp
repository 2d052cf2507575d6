// Whether a campaign rests on the control of the campaigns before: what all of them share is shared only then.
#pragma once

#include <string>
#include <vector>

#include "artifacts/loop_state.hpp"

namespace plumbline::loop {

using ControlMarks = std::vector<std::unique_ptr<ControlMarkT>>;

struct ControlChange {
  std::vector<std::string> moved;        ///< "CP3 by 4.0 mm": has other coordinates than before
  std::vector<std::string> gone, added;  ///< names: of the campaigns before alone, of this one alone
  double largest = 0;                    ///< of the moved ones [m]
  bool none() const { return moved.empty() && gone.empty() && added.empty(); }
};

/// Coordinates differ by more than a micrometre. Nothing where one of the two does not say its control. A mark that the
/// last campaign did not have is `added` when it is there again, and `moved` too if it is elsewhere than before.
ControlChange control_change(const ControlMarks& before, const ControlMarks& now);

/// What the state keeps: the marks of this campaign, and those of before that it does not have, as `missing`. A place
/// within a micrometre of the one before stays that one, so that such steps do not add up unseen.
ControlMarks kept_control(const ControlMarks& before, const ControlMarks& now);

/// "the control is not that of the campaigns before: CP3 by 4.0 mm; CP5 was not in them".
std::string words_of(const ControlChange& change);

/// How far this campaign's control is from each of LoopState::controls, in their order: what single campaigns moved by
/// little adds up.
std::vector<ControlChange> changes_since(const LoopStateT& state, const ControlMarks& now);

/// "the control moved in steps since this was released or verified: CP3 by 0.6 mm".
std::string words_since(const ControlChange& change);

/// Items that rest on something and do not say on which control rest on LoopState::control from now on; sets that
/// nothing rests on any more leave LoopState::controls.
void note_control(LoopStateT& state);

}  // namespace plumbline::loop

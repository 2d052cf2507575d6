#include "loop/state/next_words.hpp"

#include <cmath>
#include <map>
#include <set>
#include <vector>

#include "base/text/words.hpp"
#include "loop/state/machine.hpp"

namespace plumbline::loop {
namespace {

/// Lists of ids and, where each has a reason of its own, lines.
struct Floor {
  std::vector<std::string> set, hang, measure, idle, left_out, sills;
  std::map<std::string, std::vector<std::string>> unplanned;  ///< panels, by why
  std::set<std::string> held;                                 ///< by sills
  std::vector<std::string> lines;
};

struct Counts {
  int panels = 0, hang = 0, released = 0, measured = 0, waiting = 0, rejected = 0, unseen = 0, left = 0;
  int unplanned = 0, behind = 0;  ///< of those that wait: not planned; for another one that is to hang before it
  std::string down;               ///< the first that is to be taken down; empty: none
};

/// A panel that hangs by a report alone, and is right if it hangs.
bool is_unseen(const LoopItemT& item) {
  return item.kind == "panel" && item.status == ItemStatus::relocalised && item.hangs && !item.seen;
}

/// What to say of a panel that may not hang.
std::string which_words(const LoopStateT& state, const LoopItemT& item) {
  return "; if it hangs as it should, run with reported.with.accept=['" + hangs_word(state, item.id) +
         "'], else with reported.with.removed=['" + look_word(state, item.id) + "']";
}

std::string removed_words(const LoopStateT& state, const LoopItemT& item) {
  return "; if it does not, run with reported.with.removed=['" + look_word(state, item.id) + "']";
}

void add(const LoopStateT& state, const LoopItemT& item, Floor& floor, Counts& counts) {
  const bool is_panel = item.kind == "panel";
  if (item.gone) {
    if (!item.hangs) return;
    floor.lines.push_back("look whether " + item.id + " is to be taken down: the design does not have it any more" +
                          "; when it is down, run with reported.with.removed=['" + look_word(state, item.id) + "']");
    ++counts.left;
    return;
  }
  counts.panels += is_panel, counts.hang += is_panel && item.status == ItemStatus::verified;
  switch (item.status) {
    case ItemStatus::released:
    case ItemStatus::executing:
      (is_panel ? floor.hang : floor.set).push_back(item.id), ++counts.released;
      break;
    case ItemStatus::executed:
    case ItemStatus::relocalised:
      if (is_unseen(item))
        floor.lines.push_back("look whether " + item.id + " hangs: nothing has measured it there" +
                              removed_words(state, item)),
            ++counts.unseen;
      else
        floor.measure.push_back(item.id), ++counts.measured;
      break;
    case ItemStatus::rejected:
      floor.lines.push_back("look at " + item.id + ": " + item.why +
                            (may_not_hang(item) ? which_words(state, item) : "")),
          ++counts.rejected;
      break;
    case ItemStatus::rework:  // of a panel that hangs
      floor.lines.push_back("take down " + item.id + ": " + item.why);
      ++counts.rejected;
      if (counts.down.empty()) counts.down = item.id;
      break;
    case ItemStatus::planned:
      if (is_panel && item.reason == ItemReason::not_planned)
        floor.unplanned[item.why].push_back(item.id), ++counts.waiting, ++counts.unplanned;
      else if (is_panel)
        floor.lines.push_back(item.id + (item.why.rfind("waits", 0) == 0 ? " " : " waits: ") + item.why),
            ++counts.waiting, counts.behind += item.reason == ItemReason::waits_for_panel;
      else if (!item.holds.empty())
        floor.sills.push_back(item.id), floor.held.insert(item.holds.begin(), item.holds.end());
      else if (item.reason == ItemReason::holds_nothing)
        floor.idle.push_back(item.id);
      else if (item.reason == ItemReason::not_planned)
        floor.left_out.push_back(item.id);
      break;
    default:
      break;
  }
}

std::string step_words(const LoopStateT& state, const Counts& counts) {
  if (!state.doubts.empty())
    return "mend the measurement, it decides nothing: " + state.doubts.front() + "; then measure and run again";
  if (!state.moved_control.empty())
    return "look at the " + state.moved_control.front() +
           ", then measure again; if it is in order, run with reported.with.accept=['" +
           look_word(state, state.moved_control.front()) + "']";
  if (!counts.down.empty())
    return "take down what is named below, and run with reported.with.removed=['" + look_word(state, counts.down) +
           "'] for each" + (counts.released > 0 ? "; give the job to the robots, then measure and run again" : "");
  if (counts.released > 0) return "give the job to the robots, then measure and run again";
  if (counts.measured > 0) return "measure, then run again";
  if (state.to_measure) return "measure once more, then run again: what waits is likely to fit as it stands";
  if (state.to_plan) return "run again with this state: brackets are to be planned anew, by the same measurement";
  if (counts.rejected > 0 || counts.unseen > 0)
    return "somebody looks at what is named below; then run with reported.with.accept=['" + look_word(state, "NAME") +
           "'] for each that is in order";
  if (counts.left > 0) return "somebody looks whether what the design does not have any more is to be taken down";
  if (counts.unplanned > 0 && counts.waiting == counts.unplanned + counts.behind)
    return "measure the anchors of the panels below that are not planned, then run again";
  if (counts.waiting > 0)
    return "nothing may be hung as it stands: do what the lines below ask for, then measure and run again";
  return counts.panels > 0 && counts.hang == counts.panels ? "nothing: every panel hangs within its limits"
                                                           : "nothing is planned";
}

/// What verification rests on, and cannot tell.
std::string untold_words(const LoopStateT& state) {
  int told = 0, untold = 0;
  double from = 0;
  for (const auto& item : state.items) {
    if (item->kind != "panel" || item->status != ItemStatus::verified || item->gone) continue;
    (std::isnan(item->told_from) ? untold : told)++, from = std::fmax(from, item->told_from);
  }
  const std::string what = "no campaign tells a plate that was knocked before it was measured first: ";
  std::string text;
  if (told > 0)
    text += what + "the measured places of " + std::to_string(told) + " verified panels would, from a shift of " +
            text::millimetres(from) + " at their centre on (four times in five)\n";
  if (untold > 0)
    text += what + "of " + std::to_string(untold) +
            " verified panels nothing would, give their measured place with its sigma\n";
  return text;
}

}  // namespace

std::string next_step(const LoopStateT& state) {
  Floor unused;
  Counts counts;
  for (const auto& item : state.items) add(state, *item, unused, counts);
  return step_words(state, counts);
}

std::string next_words(const LoopStateT& state) {
  std::map<int, Floor> floors;
  Counts counts;
  for (const auto& item : state.items) add(state, *item, floors[item->floor], counts);
  std::string text = std::to_string(counts.hang) + " of " + std::to_string(counts.panels) +
                     " panels hang and are verified, after round " + std::to_string(state.round) + "; " +
                     std::to_string(counts.released) + " items are released (revision " +
                     std::to_string(state.revision) + "), " + std::to_string(counts.measured) + " to be measured, " +
                     std::to_string(counts.waiting) + " panels wait, " + std::to_string(counts.rejected) +
                     " are for a person, " + std::to_string(counts.unseen) + " nobody has seen hang\n";
  text += "next: " + step_words(state, counts) + "\n";
  for (const std::string& doubt : state.doubts) text += "the measurement is in doubt: " + doubt + "\n";
  for (const std::string& control : state.moved_control) text += "check the control: " + control + " moved\n";
  for (const auto& refused : state.refused)
    if (refused->round == state.round) text += "not taken: " + refused->report + ": " + refused->why + "\n";
  for (const auto& [number, floor] : floors) {
    const std::string begin = "floor " + std::to_string(number) + ": ";
    if (!floor.set.empty()) text += begin + "set " + text::join(floor.set) + "\n";
    if (!floor.hang.empty()) text += begin + "hang " + text::join(floor.hang) + "\n";
    if (!floor.measure.empty()) text += begin + "measure " + text::join(floor.measure) + "\n";
    for (const std::string& line : floor.lines) text += begin + line + "\n";
    for (const auto& [why, panels] : floor.unplanned)
      text += begin + text::join(panels, 8) + (panels.size() > 1 ? " are" : " is") + " not planned: " + why + "\n";
    if (!floor.left_out.empty() && floor.unplanned.empty())
      text += begin + "the panels on " + text::join(floor.left_out) + " are not planned: installation.txt says why\n";
    if (!floor.sills.empty())
      text += begin + text::join(floor.sills) + " hold the bottom edges of " +
              text::join({floor.held.begin(), floor.held.end()}) + ": nothing is to be set there\n";
    if (!floor.idle.empty())
      text += begin + "no panel hangs on " + text::join(floor.idle) + ": nothing is to be set there\n";
  }
  return text + untold_words(state);
}

}  // namespace plumbline::loop

// What a person has looked at, and after which round.
#include <algorithm>

#include "loop/fit/facade.hpp"
#include "loop/state/machine.hpp"
#include "loop/state/transitions.hpp"

namespace plumbline::loop {

namespace {

/// Measurements of a floor on control that somebody has looked at: what was measured before is no reference any more.
bool accept_control(LoopStateT& state, const std::string& name) {
  const auto known = std::find(state.moved_control.begin(), state.moved_control.end(), name);
  if (known == state.moved_control.end()) return false;
  state.moved_control.erase(known);
  for (auto& item : state.items)
    if (item->kind == "bracket" && control_of_floor(item->floor) == name)
      item->expected.setConstant(kUnknown), item->unset.clear();
  return true;
}

}  // namespace

bool accept_item(LoopStateT& state, const std::string& id) {
  bool found = accept_control(state, id);
  for (auto& item : state.items) {
    if (item->id == id && item->hangs && !item->seen) {
      found = item->seen = true;
      note(state, *item, {"a person has seen it hang", {}, {}, {}});
    }
    if (item->id != id || item->status != ItemStatus::rejected) continue;
    found = true, item->reworks = item->waited = 0;
    item->place.clear();  // somebody has looked at what it contradicted
    // What hangs is not released again: the next measurement judges it.
    move(state, *item, item->hangs ? ItemStatus::relocalised : ItemStatus::planned,
         {"accepted by a person", {}, {}, {}});
    if (item->kind == "bracket") item->expected.setConstant(kUnknown);
  }
  return found;
}

std::string look_word(const LoopStateT& state, const std::string& name) {
  return name + "@" + std::to_string(state.round);
}

std::string accept_look(LoopStateT& state, const std::string& word) {
  const auto at = word.rfind('@');
  const std::string name = word.substr(0, at), round = at == std::string::npos ? "" : word.substr(at + 1);
  const bool is_round = !round.empty() && round.find_first_not_of("0123456789") == std::string::npos;
  if (is_round && round == std::to_string(state.round))
    return accept_item(state, name) ? std::string()
                                    : "'" + name +
                                          "' is no rejected bracket or panel of the state, no panel that nobody has "
                                          "seen hang and no control that it reports as moved";
  const std::string wanted = "'" + look_word(state, is_round ? name : word) + "'";
  return is_round ? "'" + word + "' is of round " + round + ", the state is after round " +
                        std::to_string(state.round) + ": if somebody has looked since, say " + wanted
                  : "'" + word + "' says no round: if somebody has looked after round " + std::to_string(state.round) +
                        ", say " + wanted;
}

}  // namespace plumbline::loop

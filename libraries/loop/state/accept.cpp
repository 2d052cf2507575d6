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

constexpr const char* kHangs = " hangs";

LoopItemT* panel_of(const LoopStateT& state, const std::string& id) {
  for (const auto& item : state.items)
    if (item->kind == "panel" && item->id == id) return item.get();
  return nullptr;
}

/// Why a word is not of what somebody looked at after the last round; empty: it is, and `name` what it names.
std::string other_look(const LoopStateT& state, const std::string& word, std::string& name) {
  const auto at = word.rfind('@');
  const std::string round = at == std::string::npos ? "" : word.substr(at + 1);
  name = word.substr(0, at);
  const bool is_round = !round.empty() && round.find_first_not_of("0123456789") == std::string::npos;
  if (is_round && round == std::to_string(state.round)) return {};
  const std::string wanted = "'" + look_word(state, is_round ? name : word) + "'";
  return is_round ? "'" + word + "' is of round " + round + ", the state is after round " +
                        std::to_string(state.round) + ": if somebody has looked since, say " + wanted
                  : "'" + word + "' says no round: if somebody has looked after round " + std::to_string(state.round) +
                        ", say " + wanted;
}

}  // namespace

bool may_not_hang(const LoopItemT& item) {
  return item.kind == "panel" && item.status == ItemStatus::rejected && item.hangs && !item.seen;
}

Because told(const LoopStateT& state, const Teller& teller, std::string why) {
  const std::string who = teller.by.empty() ? Teller().by : teller.by;
  std::vector<std::string> rests_on;
  if (!state.basis.empty()) rests_on.push_back(state.basis);
  return {std::move(why), {}, {}, std::move(rests_on), ItemReason::other, who, teller.at};
}

bool accept_item(LoopStateT& state, const std::string& id, const Teller& teller) {
  bool found = accept_control(state, id);
  for (auto& item : state.items) {
    if (item->id == id && item->hangs && !item->seen) {
      found = item->seen = true;
      note(state, *item, told(state, teller, "a person has seen it hang"));
    }
    if (item->id != id || item->status != ItemStatus::rejected) continue;
    found = true, item->reworks = item->waited = 0;
    item->place.clear();  // somebody has looked at what it contradicted
    // What hangs is not released again: the next measurement judges it.
    move(state, *item, item->hangs ? ItemStatus::relocalised : ItemStatus::planned,
         told(state, teller, "accepted by a person"));
    if (item->kind == "bracket") item->expected.setConstant(kUnknown);
  }
  return found;
}

std::string look_word(const LoopStateT& state, const std::string& name) {
  return name + "@" + std::to_string(state.round);
}

std::string hangs_word(const LoopStateT& state, const std::string& name) { return look_word(state, name + kHangs); }

std::string accept_look(LoopStateT& state, const std::string& word, const Teller& teller) {
  std::string name;
  if (const std::string why = other_look(state, word, name); !why.empty()) return why;
  const bool says_it_hangs = name.ends_with(kHangs) && panel_of(state, name) == nullptr;
  if (says_it_hangs) name.resize(name.size() - std::string(kHangs).size());
  const LoopItemT* panel = panel_of(state, name);
  if (panel && may_not_hang(*panel) && !says_it_hangs)
    return "'" + word + "' does not say whether it hangs: if it does, say '" + hangs_word(state, name) +
           "', else reported.with.removed=['" + look_word(state, name) + "']";
  return accept_item(state, name, teller)
             ? std::string()
             : "'" + name +
                   "' is no rejected bracket or panel of the state, no panel that nobody has "
                   "seen hang and no control that it reports as moved";
}

std::string remove_look(LoopStateT& state, const std::string& word, const Teller& teller) {
  std::string name;
  if (const std::string why = other_look(state, word, name); !why.empty()) return why;
  LoopItemT* panel = panel_of(state, name);
  if (!panel || !panel->hangs) return "'" + name + "' is no panel that hangs by what was reported";
  unhang(state, *panel, told(state, teller, "a person took it down, or found that it does not hang"));
  return {};
}

}  // namespace plumbline::loop

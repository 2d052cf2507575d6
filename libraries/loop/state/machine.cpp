#include "loop/state/machine.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <set>
#include <stdexcept>

#include "loop/state/date.hpp"
#include "loop/state/next_words.hpp"
#include "loop/state/transitions.hpp"

namespace plumbline::loop {

const char* name_of(ItemStatus status) {
  static constexpr const char* kNames[] = {"PLANNED",  "RELEASED", "EXECUTING", "EXECUTED", "RELOCALISED",
                                           "VERIFIED", "REWORK",   "REJECTED",  "STALE"};
  const auto at = static_cast<std::size_t>(status);
  return at < std::size(kNames) ? kNames[at] : "?";
}

bool may_follow(ItemStatus from, ItemStatus to) {
  using S = ItemStatus;
  static const std::map<S, std::set<S>> next = {
      {S::planned, {S::released, S::verified, S::rejected}},
      {S::released, {S::executing, S::executed, S::stale, S::planned, S::rework}},
      {S::executing, {S::executed, S::planned, S::rework}},
      {S::executed, {S::relocalised}},
      {S::relocalised, {S::verified, S::rework}},
      {S::verified, {S::relocalised, S::rework}},
      {S::rework, {S::planned, S::rejected, S::relocalised}},
      {S::rejected, {S::planned, S::relocalised}},
      {S::stale, {S::planned}}};
  return next.at(from).count(to) > 0;
}

std::string control_of_floor(int floor) { return "control of floor " + std::to_string(floor); }

std::string control_without_floor(const LoopStateT& state) {
  for (const std::string& name : state.moved_control)
    if (std::none_of(state.items.begin(), state.items.end(),
                     [&](const auto& item) { return control_of_floor(item->floor) == name; }))
      return name;
  return {};
}

namespace {

void write_line(LoopStateT& state, const LoopItemT& item, ItemStatus to, const Because& because, int reported = 0,
                int answered = 0) {
  const bool has_reason = because.reason != ItemReason::other;
  state.journal.push_back(journal_line(
      {state.round, item.id, item.kind, name_of(item.status), name_of(to),
       because.by.empty() ? because.told_by : because.by, because.at.empty() ? because.told_at : because.at,
       because.why, because.rests_on, has_reason ? EnumNameItemReason(because.reason) : "", reported, answered},
      journal_head(state.journal)));
}

}  // namespace

void move(LoopStateT& state, LoopItemT& item, ItemStatus to, const Because& because) {
  if (!may_follow(item.status, to))
    throw std::logic_error(item.kind + " " + item.id + " cannot go from " + name_of(item.status) + " to " +
                           name_of(to));
  write_line(state, item, to, because);
  item.status = to, item.why = because.why, item.reason = because.reason;
  if (to == ItemStatus::planned || to == ItemStatus::rejected) item.control = 0;
  if (!because.by.empty()) item.by = because.by;
  if (!because.at.empty()) item.at = because.at;
}

void note(LoopStateT& state, LoopItemT& item, const Because& because) {
  write_line(state, item, item.status, because);
  item.why = because.why, item.reason = because.reason;
}

void note_recalled_order(LoopStateT& state, const LoopItemT& item, const Because& because, int reported, int answered) {
  write_line(state, item, item.status, because, reported, answered);
}

void reject_item(LoopStateT& state, LoopItemT& item, const Because& because) {
  using S = ItemStatus;
  if (item.status == S::released) move(state, item, S::stale, because), move(state, item, S::planned, because);
  if (item.status == S::executed) move(state, item, S::relocalised, because);
  if (item.status == S::relocalised || item.status == S::verified) move(state, item, S::rework, because);
  if (item.status == S::planned || item.status == S::rework) move(state, item, S::rejected, because);
  item.pending.setZero();
}

void unhang(LoopStateT& state, LoopItemT& panel, const Because& because) {
  using S = ItemStatus;
  if (panel.status == S::executed) move(state, panel, S::relocalised, because);
  if (panel.status == S::relocalised || panel.status == S::verified) move(state, panel, S::rework, because);
  move(state, panel, S::planned, because);
  panel.hangs = panel.seen = false;
  panel.place.clear(), panel.told_from = std::nan("");
}

void reject_what_stands_on(LoopStateT& state, const LoopItemT& sill, const Because& because) {
  for (auto& item : state.items)
    if (item->kind == "panel" && item->status != ItemStatus::planned && item->status != ItemStatus::rejected &&
        std::count(sill.holds.begin(), sill.holds.end(), item->id) > 0)
      reject_item(state, *item,
                  {"its sill " + sill.id + " " + because.why,
                   because.by,
                   {},
                   because.rests_on,
                   because.reason,
                   because.told_by,
                   because.told_at});
}

const LoopItemT* sill_for_a_person(const LoopStateT& state, const std::string& panel) {
  for (const auto& item : state.items)
    if (item->status == ItemStatus::rejected && std::count(item->holds.begin(), item->holds.end(), panel) > 0)
      return item.get();
  return nullptr;
}

std::string time_doubt(const LoopStateT& state, const std::string& now) {
  const std::optional<double> here = seconds_of(now);
  for (const auto& item : state.items) {
    const std::optional<double> released = seconds_of(item->at);
    if (item->status == ItemStatus::released && here && released && *released > *here)
      return "this round is said to be at " + now + ", and " + item->id + " was released at " + item->at +
             ", after it: 'now' is of another round, or in another zone";
  }
  return {};
}

void recall(LoopStateT& state, const std::vector<std::string>& moved_control, const std::string& why,
            const Teller& teller) {
  for (const std::string& id : moved_control)
    if (std::find(state.moved_control.begin(), state.moved_control.end(), id) == state.moved_control.end())
      state.moved_control.push_back(id);
  for (auto& item : state.items) {
    if (item->status != ItemStatus::released) continue;
    move(state, *item, ItemStatus::stale, told(state, teller, why));
    move(state, *item, ItemStatus::planned, told(state, teller, "stale: " + why));
    item->pending.setZero();
  }
}

void close_round(LoopStateT& state) {
  state.verified = state.given_up = 0;
  bool open = state.to_plan || state.to_measure;
  const bool blocked = !control_without_floor(state).empty();
  const auto in_doubt = [&](int floor) {
    return std::count(state.moved_control.begin(), state.moved_control.end(), control_of_floor(floor)) > 0;
  };
  for (const auto& item : state.items) {
    if (item->gone) continue;
    state.verified += item->status == ItemStatus::verified;
    state.given_up += item->status == ItemStatus::rejected;
    // Who is to look at the control of its floor is a person, and so is who sees whether a panel hangs.
    if (item->status == ItemStatus::relocalised && item->hangs && !item->seen) continue;
    open =
        open || item->status == ItemStatus::released || item->status == ItemStatus::executing ||
        ((item->status == ItemStatus::executed || item->status == ItemStatus::relocalised) && !in_doubt(item->floor));
  }
  open = open && !blocked;
  ++state.round;
  state.done = !open, state.next = next_step(state);
}

}  // namespace plumbline::loop

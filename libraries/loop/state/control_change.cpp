#include "loop/state/control_change.hpp"

#include <algorithm>
#include <map>
#include <set>

#include "base/text/words.hpp"

namespace plumbline::loop {
namespace {

constexpr double kSame = 1e-6;  ///< [m]

/// Names that are told.
constexpr std::size_t kMost = 6;

}  // namespace

ControlChange control_change(const ControlMarks& before, const ControlMarks& now) {
  ControlChange change;
  if (before.empty() || now.empty()) return change;
  std::map<std::string, const ControlMarkT*> known;
  for (const auto& mark : before) known[mark->id] = mark.get();
  for (const auto& mark : now) {
    const auto found = known.find(mark->id);
    if (found == known.end()) {
      change.added.push_back(mark->id);
      continue;
    }
    const double off = (mark->place - found->second->place).norm();
    if (found->second->missing) change.added.push_back(mark->id);
    known.erase(found);
    if (off <= kSame) continue;
    change.moved.push_back(mark->id + " by " + text::millimetres(off));
    change.largest = std::max(change.largest, off);
  }
  for (const auto& [id, mark] : known)
    if (!mark->missing) change.gone.push_back(id);
  return change;
}

ControlMarks kept_control(const ControlMarks& before, const ControlMarks& now) {
  ControlMarks kept;
  std::set<std::string> there;
  std::map<std::string, const ControlMarkT*> known;
  for (const auto& mark : before) known[mark->id] = mark.get();
  for (const auto& mark : now) {
    kept.push_back(std::make_unique<ControlMarkT>(*mark));
    if (const auto found = known.find(mark->id);
        found != known.end() && (found->second->place - mark->place).norm() <= kSame)
      kept.back()->place = found->second->place;
    there.insert(mark->id);
  }
  for (const auto& mark : before)
    if (there.insert(mark->id).second) {
      kept.push_back(std::make_unique<ControlMarkT>(*mark));
      kept.back()->missing = true;
    }
  return kept;
}

std::string words_of(const ControlChange& change) {
  if (change.none()) return {};
  std::string words;
  if (!change.moved.empty()) words += "; it has other coordinates: " + text::join(change.moved, kMost);
  if (!change.added.empty()) words += "; they did not have " + text::join(change.added, kMost);
  if (!change.gone.empty()) words += "; this campaign does not have " + text::join(change.gone, kMost);
  return "the control is not that of the campaigns before: " + words.substr(2);
}

std::vector<ControlChange> changes_since(const LoopStateT& state, const ControlMarks& now) {
  std::vector<ControlChange> changes;
  for (const auto& set : state.controls) changes.push_back(control_change(set->marks, now));
  return changes;
}

std::string words_since(const ControlChange& change) {
  return "the control moved in steps since this was released or verified: " + text::join(change.moved, kMost);
}

namespace {

bool is_same(const ControlMarks& a, const ControlMarks& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const auto& left, const auto& right) {
    return left->id == right->id && left->place == right->place && left->missing == right->missing;
  });
}

/// Planned, rejected or recalled, an item rests on no control.
bool rests_on_control(const LoopItemT& item) {
  return item.status != ItemStatus::planned && item.status != ItemStatus::rejected && item.status != ItemStatus::stale;
}

}  // namespace

void note_control(LoopStateT& state) {
  std::vector<std::unique_ptr<ControlSetT>> sets = std::move(state.controls);
  if (!state.control.empty() && (sets.empty() || !is_same(sets.back()->marks, state.control))) {
    sets.push_back(std::make_unique<ControlSetT>());
    for (const auto& mark : state.control) sets.back()->marks.push_back(std::make_unique<ControlMarkT>(*mark));
  }
  std::set<int> used;
  for (auto& item : state.items) {
    if (!rests_on_control(*item))
      item->control = 0;
    else if (item->control == 0 && !state.control.empty())
      item->control = static_cast<int>(sets.size());
    if (item->control > 0) used.insert(item->control);
  }
  std::map<int, int> place;
  state.controls.clear();
  for (const int number : used) {
    state.controls.push_back(std::move(sets[number - 1]));
    place[number] = static_cast<int>(state.controls.size());
  }
  for (auto& item : state.items)
    if (item->control > 0) item->control = place.at(item->control);
}

}  // namespace plumbline::loop

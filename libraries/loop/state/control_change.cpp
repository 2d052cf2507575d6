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
  for (const auto& mark : now) {
    kept.push_back(std::make_unique<ControlMarkT>(*mark));
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

}  // namespace plumbline::loop

#include "loop/state/control_change.hpp"

#include <algorithm>
#include <map>

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
  std::map<std::string, Eigen::Vector3d> known;
  for (const auto& mark : before) known[mark->id] = mark->place;
  for (const auto& mark : now) {
    const auto found = known.find(mark->id);
    if (found == known.end()) {
      change.added.push_back(mark->id);
      continue;
    }
    const double off = (mark->place - found->second).norm();
    known.erase(found);
    if (off <= kSame) continue;
    change.moved.push_back(mark->id + " by " + text::millimetres(off));
    change.largest = std::max(change.largest, off);
  }
  for (const auto& [id, place] : known) change.gone.push_back(id);
  return change;
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

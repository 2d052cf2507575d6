#include "loop/state/control_change.hpp"

#include <algorithm>
#include <map>

#include "loop/state/transitions.hpp"

namespace plumbline::loop {
namespace {

constexpr double kSame = 1e-6;  ///< [m]

std::string listed(const std::vector<std::string>& names) {
  constexpr std::size_t kMost = 6;
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), kMost); ++i) text += (i > 0 ? ", " : "") + names[i];
  return names.size() > kMost ? text + " and " + std::to_string(names.size() - kMost) + " more" : text;
}

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
    change.moved.push_back(mark->id + " by " + millimetres(off));
    change.largest = std::max(change.largest, off);
  }
  for (const auto& [id, place] : known) change.gone.push_back(id);
  return change;
}

std::string words_of(const ControlChange& change) {
  if (change.none()) return {};
  std::string text;
  if (!change.moved.empty()) text += "; it has other coordinates: " + listed(change.moved);
  if (!change.added.empty()) text += "; they did not have " + listed(change.added);
  if (!change.gone.empty()) text += "; this campaign does not have " + listed(change.gone);
  return "the control is not that of the campaigns before: " + text.substr(2);
}

}  // namespace plumbline::loop

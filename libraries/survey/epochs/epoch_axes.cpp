#include "survey/epochs/epoch_axes.hpp"

#include <algorithm>

#include "survey/words/network_words.hpp"

namespace plumbline::survey {

namespace {

/// "E", "E and N", "E, N and H".
std::string axis_names(const std::string& letters) {
  std::string text;
  for (std::size_t k = 0; k < letters.size(); ++k)
    text += (k == 0 ? "" : k + 1 == letters.size() ? " and " : ", ") + std::string(1, letters[k]);
  return text;
}

}  // namespace

ComparedAxes compared_axes(const std::vector<std::array<Measured, 3>>& epochs) {
  ComparedAxes best;
  std::size_t most = 0;
  for (unsigned set = 7; set > 0; --set) {
    ComparedAxes trial;
    for (Eigen::Index c = 0; c < 3; ++c)
      if (set >> c & 1U) trial.axes.push_back(c);
    for (std::size_t k = 0; k < epochs.size(); ++k)
      if (std::all_of(trial.axes.begin(), trial.axes.end(),
                      [&](Eigen::Index c) { return epochs[k][static_cast<std::size_t>(c)] == Measured::yes; }))
        trial.epochs.push_back(k);
    if (trial.epochs.size() < 2) continue;
    const std::size_t size = trial.axes.size() * (trial.epochs.size() - 1);
    if (size > most || (size == most && trial.axes.size() > best.axes.size())) most = size, best = std::move(trial);
  }
  return best;
}

void NotCompared::add(std::size_t epoch, const std::string& axes, Measured why, const std::string& id) {
  if (axes.empty()) return;
  const auto same = std::find_if(groups_.begin(), groups_.end(),
                                 [&](const Group& g) { return g.epoch == epoch && g.axes == axes && g.why == why; });
  if (same != groups_.end())
    same->ids.push_back(id);
  else
    groups_.push_back({epoch, axes, why, {id}});
}

void NotCompared::add(const std::string& id, const std::vector<std::array<Measured, 3>>& seen,
                      const std::vector<std::size_t>& numbers, const ComparedAxes& compared) {
  const auto is_compared = [&](std::size_t c) {
    return std::find(compared.axes.begin(), compared.axes.end(), static_cast<Eigen::Index>(c)) != compared.axes.end();
  };
  std::string never;
  bool any_held = false;
  for (std::size_t c = 0; c < 3; ++c) {
    const auto is = [&](Measured m) {
      return std::any_of(seen.begin(), seen.end(), [&](const auto& s) { return s[c] == m; });
    };
    // What no epoch has is no loss, and what is held wherever it is seen was never to be compared.
    if (is_compared(c) || seen.size() < 2 || !is(Measured::yes)) continue;
    never += "ENH"[c];
    any_held |= is(Measured::held);
  }
  add(kAll, never, any_held ? Measured::held : Measured::missing, id);
  if (compared.axes.empty()) return;
  for (std::size_t k = 0; k < seen.size(); ++k)
    for (const Measured why : {Measured::held, Measured::missing}) {
      std::string axes;
      for (std::size_t c = 0; c < 3; ++c)
        if (is_compared(c) && seen[k][c] == why) axes += "ENH"[c];
      add(numbers[k], axes, why, id);
    }
}

std::vector<std::string> NotCompared::words(const std::vector<std::string>& epoch_names) const {
  std::vector<std::string> all;
  for (const Group& g : groups_) {
    const std::string what = axis_names(g.axes) + " of " + join(g.ids);
    if (g.epoch == kAll)
      all.push_back(what + (g.why == Measured::held
                                ? ": held in one epoch or more, not measured, and so compared in none"
                                : ": not measured in every epoch that has the rest of the point, and so compared "
                                  "in none"));
    else
      all.push_back(epoch_names[g.epoch] + ": " + what +
                    (g.why == Measured::held ? " held there, not measured" : " not measured there") +
                    "; the point is compared in the other epochs only");
  }
  return all;
}

}  // namespace plumbline::survey

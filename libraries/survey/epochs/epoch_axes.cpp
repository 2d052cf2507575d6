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

std::array<bool, 3> compared_axes(const std::vector<std::array<Measured, 3>>& epochs) {
  std::array<bool, 3> compared = {};
  for (std::size_t c = 0; c < 3; ++c)
    compared[c] = std::count_if(epochs.begin(), epochs.end(), [&](const auto& e) { return e[c] == Measured::yes; }) > 1;
  return compared;
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
                      const std::vector<std::size_t>& numbers, const std::array<bool, 3>& compared) {
  std::string never;
  bool any_held = false;
  for (std::size_t c = 0; c < 3; ++c) {
    const auto is = [&](Measured m) {
      return std::any_of(seen.begin(), seen.end(), [&](const auto& s) { return s[c] == m; });
    };
    // What no epoch has is no loss, and what is held wherever it is seen was never to be compared.
    if (compared[c] || seen.size() < 2 || !is(Measured::yes)) continue;
    never += "ENH"[c];
    any_held |= is(Measured::held);
  }
  add(kAll, never, any_held ? Measured::held : Measured::missing, id);
  for (std::size_t k = 0; k < seen.size(); ++k)
    for (const Measured why : {Measured::held, Measured::missing}) {
      std::string axes;
      for (std::size_t c = 0; c < 3; ++c)
        if (compared[c] && seen[k][c] == why) axes += "ENH"[c];
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
                                : ": measured in one epoch only, and so compared in none"));
    else
      all.push_back(epoch_names[g.epoch] + ": " + what +
                    (g.why == Measured::held ? " held there, not measured" : " not measured there") +
                    "; compared in the other epochs only");
  }
  return all;
}

}  // namespace plumbline::survey

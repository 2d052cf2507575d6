// Part of approximate.cpp: places that fit equally well. A search that meets one takes the first place and writes down
// that there were others; the next search takes another.
#pragma once

#include <algorithm>
#include <cstddef>
#include <map>
#include <string>
#include <vector>

namespace plumbline::survey {

struct Choice {
  std::string key;  ///< which point, in which frame
  int places = 0;   ///< how many fit
};

class Choices {
 public:
  explicit Choices(std::map<std::string, int> decided = {}) : decided_(std::move(decided)) {}

  /// Which of `places` (> 1) to take.
  int choose(const std::string& key, int places) {
    const auto same = [&](const Choice& c) { return c.key == key; };
    if (std::none_of(met_.begin(), met_.end(), same)) met_.push_back({key, places});
    const auto at = decided_.find(key);
    return at == decided_.end() ? 0 : std::min(at->second, places - 1);
  }
  /// In the order they were met.
  const std::vector<Choice>& met() const { return met_; }
  /// What was decided up to the n-th choice, and `place` there.
  std::map<std::string, int> decide(size_t n, int place) const {
    std::map<std::string, int> decided;
    for (size_t i = 0; i < n; ++i) {
      const auto at = decided_.find(met_[i].key);
      if (at != decided_.end()) decided.insert(*at);
    }
    decided[met_[n].key] = place;
    return decided;
  }

 private:
  std::map<std::string, int> decided_;
  std::vector<Choice> met_;
};

}  // namespace plumbline::survey

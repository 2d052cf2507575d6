#include "bench/duels.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <tuple>

namespace plumbline::bench {
namespace {

using statistics::Pair;

/// The cells of one group's two alternatives that differ in nothing else.
class DuelBuilder {
 public:
  DuelBuilder(const Bench& bench, const Group& group, const std::string& first, const std::string& second)
      : group_(group), costs_count_(costs_count(bench, group)), first_(first), second_(second) {
    std::map<std::tuple<std::string, std::string, std::uint64_t>, std::pair<const Cell*, const Cell*>> twins;
    for (const Cell& cell : bench.cells) {
      const auto choice = cell.choices.find(group.name);
      if (choice == cell.choices.end()) continue;
      auto& twin = twins[{cell.place, choices_text(cell.choices, group.name), cell.seed}];
      if (choice->second == first) twin.first = &cell;
      if (choice->second == second) twin.second = &cell;
    }
    for (const auto& [key, twin] : twins)
      if (twin.first && twin.second) twins_[std::get<0>(key)].push_back(twin);
  }

  /// Of one place, or of all if `place` is null.
  Duel duel(const std::string* place, const statistics::ResamplingOptions& options) const {
    Duel duel;
    duel.group = group_.name, duel.first = first_, duel.second = second_;
    if (place) duel.place = *place;
    duel.overall = !place;
    std::vector<std::vector<Pair>> strata;
    std::vector<Pair> seconds;
    for (const auto& [name, twins] : twins_) {
      if (place && name != *place) continue;
      add_place(twins, duel, strata, seconds);
    }
    if (!duel.refused.empty()) return duel;
    duel.errors = compare_pairs(strata, options);
    duel.times = compare_times(seconds, options);
    return duel;
  }

 private:
  using Twin = std::pair<const Cell*, const Cell*>;

  /// A trial is one seed: what else varies (other groups) is averaged within it, because it is the same site.
  void add_place(const std::vector<Twin>& twins, Duel& duel, std::vector<std::vector<Pair>>& strata,
                 std::vector<Pair>& seconds) const {
    struct Sum {
      double first = 0, second = 0, count = 0;
    };
    std::map<std::uint64_t, Sum> by_seed;
    const std::set<std::string> nodes(group_.nodes.begin(), group_.nodes.end());
    for (const auto& [a, b] : twins) {
      const bool first_done = a->status == "done", second_done = b->status == "done";
      duel.only_first += first_done && b->status == "failed";
      duel.only_second += second_done && a->status == "failed";
      if (!first_done || !second_done) continue;
      refuse_other_starts(*a, *b, duel);
      Sum& sum = by_seed[a->seed];
      sum.first += a->measure("error") * a->measure("error");
      sum.second += b->measure("error") * b->measure("error");
      ++sum.count;
      seconds.push_back({seconds_in(*a, nodes, group_.whole_pipelines), seconds_in(*b, nodes, group_.whole_pipelines)});
    }
    strata.emplace_back();
    for (const auto& [seed, sum] : by_seed) strata.back().push_back({sum.first / sum.count, sum.second / sum.count});
  }

  /// Costs that the bench computed are those of one node. Alternatives before it are compared by where they make it
  /// start, and whole pipelines have costs of different problems.
  static bool costs_count(const Bench& bench, const Group& group) {
    if (bench.judged.empty()) return true;
    return !group.whole_pipelines && std::any_of(group.nodes.begin(), group.nodes.end(), [&](const std::string& node) {
      return std::find(bench.judged.begin(), bench.judged.end(), node) != bench.judged.end();
    });
  }

  void refuse_other_starts(const Cell& a, const Cell& b, Duel& duel) const {
    if (!duel.refused.empty()) return;
    const double start_a = a.measure("start_cost"), start_b = b.measure("start_cost");
    if (costs_count_ && std::isfinite(start_a) && std::isfinite(start_b) &&
        std::abs(start_a - start_b) > 1e-9 * std::max(std::abs(start_a), std::abs(start_b))) {
      duel.refused = "they started from different costs, " + std::to_string(start_a) + " and " +
                     std::to_string(start_b) + " with seed " + std::to_string(a.seed);
      return;
    }
    if (group_.whole_pipelines || group_.nodes.empty()) return;
    bool known = false, same = false;
    for (const std::string& node : group_.nodes) {
      const auto of_a = a.inputs.find(node), of_b = b.inputs.find(node);
      if (of_a == a.inputs.end() || of_b == b.inputs.end()) continue;
      known = true;
      same |= of_a->second == of_b->second;
    }
    if (known && !same)
      duel.refused = "what they started from differs in seed " + std::to_string(a.seed) + ": their node '" +
                     group_.nodes.front() + "' did not get the same inputs";
  }

  const Group& group_;
  const bool costs_count_;
  const std::string first_, second_;
  std::map<std::string, std::vector<Twin>> twins_;  // by place
};

void put_in_words(Duel& duel, double rope) {
  if (!duel.refused.empty()) {
    duel.words = duel.first + " and " + duel.second + " are not compared: " + duel.refused;
    return;
  }
  duel.words = in_words(duel.errors, duel.first, duel.second, rope, 1e3, "mm");
  if (duel.only_first + duel.only_second > 0)
    duel.words += "; compared on trials that both finished, besides them " + std::to_string(duel.only_first) +
                  " only by " + duel.first + ", " + std::to_string(duel.only_second) + " only by " + duel.second;
  const auto& ratio = duel.times.ratio;
  if (!std::isfinite(ratio.interval.lower)) return;
  if (duel.times.confirmed) {
    const bool faster = ratio.value < 1;
    const double factor = faster ? 1 / ratio.value : ratio.value;
    const double low = faster ? 1 / ratio.interval.upper : ratio.interval.lower,
                 high = faster ? 1 / ratio.interval.lower : ratio.interval.upper;
    duel.words += "; " + (faster ? duel.first : duel.second) + " is " + fixed(factor, 2) + " × faster (" +
                  fixed(low, 2) + " to " + fixed(high, 2) + ")";
  } else {
    duel.words += "; no difference in time is confirmed (ratio " + fixed(ratio.value, 2) + ", " +
                  fixed(ratio.interval.lower, 2) + " to " + fixed(ratio.interval.upper, 2) + ")";
  }
}

std::vector<Duel> duels_of(const Bench& bench, const statistics::ResamplingOptions& options) {
  std::vector<Duel> duels;
  const std::vector<std::string> places = bench.places();
  for (const Group& group : bench.groups) {
    std::vector<std::string> names = group.alternatives;
    std::sort(names.begin(), names.end());  // so that the file's order decides nothing
    for (std::size_t a = 0; a < names.size(); ++a)
      for (std::size_t b = a + 1; b < names.size(); ++b) {
        const DuelBuilder builder(bench, group, names[a], names[b]);
        if (places.size() > 1) duels.push_back(builder.duel(nullptr, options));
        for (const std::string& place : places) duels.push_back(builder.duel(&place, options));
      }
  }
  return duels;
}

/// The places are one family of tests, the answers over all places another.
void judge_family(std::vector<Duel>& duels, bool overall, double rope, double confidence) {
  std::vector<statistics::PairedComparison> family;
  for (const Duel& duel : duels)
    if (duel.overall == overall && duel.refused.empty()) family.push_back(duel.errors);
  judge(family, rope, confidence);
  std::size_t next = 0;
  for (Duel& duel : duels) {
    if (duel.overall != overall) continue;
    if (duel.refused.empty()) duel.errors = family[next++];
    put_in_words(duel, rope);
  }
}

}  // namespace

std::vector<Duel> judged_duels(const Bench& bench, const statistics::ResamplingOptions& options, double confidence) {
  std::vector<Duel> duels = duels_of(bench, options);
  judge_family(duels, true, bench.rope, confidence);
  judge_family(duels, false, bench.rope, confidence);
  return duels;
}

double seconds_in(const Cell& cell, const std::set<std::string>& nodes, bool all) {
  double sum = 0;
  std::size_t timed = 0;
  for (const auto& [node, seconds] : cell.seconds)
    if ((all && node != "start_cost" && node != "final_cost") || nodes.count(node)) sum += seconds, ++timed;
  if (timed == 0) return std::numeric_limits<double>::quiet_NaN();
  if (!all)
    for (const std::string& node : nodes)
      if (cell.inputs.count(node) && !cell.seconds.count(node)) return std::numeric_limits<double>::quiet_NaN();
  return sum;
}

std::string fixed(double value, int decimals) {
  char text[64];
  std::snprintf(text, sizeof text, "%.*f", decimals, value);
  return text;
}

}  // namespace plumbline::bench

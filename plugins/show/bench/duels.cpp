#include "show/bench/duels.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <tuple>

#include "base/text/text.hpp"

namespace plumbline::bench {
namespace {

using statistics::Encounter;
using statistics::TimePair;

/// The cells of one group's two alternatives that differ in nothing else.
class DuelBuilder {
  using Twin = std::pair<const Cell*, const Cell*>;

 public:
  DuelBuilder(const Bench& bench, const Group& group, const std::string& first, const std::string& second)
      : group_(group),
        costs_count_(costs_count(bench, group)),
        useless_above_(bench.useless_above()),
        first_(first),
        second_(second) {
    using Others = std::map<std::string, std::string>;  // what the other groups have
    std::map<std::tuple<std::string, Others, std::uint64_t>, Twin> twins;
    for (const Cell& cell : bench.cells) {
      const auto choice = cell.choices.find(group.name);
      if (choice == cell.choices.end()) continue;
      Others others = cell.choices;
      others.erase(group.name);
      auto& twin = twins[{cell.place, others, cell.seed}];
      if (choice->second == first) twin.first = &cell;
      if (choice->second == second) twin.second = &cell;
    }
    for (const auto& [key, twin] : twins)
      if (twin.first && twin.second) twins_[std::get<0>(key)].push_back(twin);
  }

  /// Of one place, or of all of the bench if `place` is null.
  Duel duel(const std::string* place, const Bench& bench, const statistics::InferenceOptions& options) const {
    Duel duel;
    duel.group = group_.name, duel.first = first_, duel.second = second_;
    if (place) duel.place = *place;
    duel.overall = !place;
    duel.weighted = !place && !bench.weights.empty();
    std::vector<statistics::Place> places;
    std::vector<TimePair> seconds;
    for (const auto& [name, twins] : twins_) {
      if (place && name != *place) continue;
      const std::size_t seeds = seeds_of_one_trial(twins);
      if (place) duel.repeated = seeds;
      const std::vector<Twin> counting = seeds > 0 ? twins_of_one_seed(twins) : twins;
      places.push_back({1, encounters(counting, duel, seconds)});
      if (duel.weighted) weigh(bench, name, twins.front().first->scenario, places.back());
    }
    refuse_what_never_ran(place, duel);
    if (duel.weighted && bench.weights_of_scenarios)  // one in which both were tried nowhere weighs all the same
      for (const auto& [scenario, weight] : bench.weights)
        if (std::none_of(places.begin(), places.end(), [&](const auto& p) { return p.stratum == scenario; }))
          places.push_back({weight, {}, scenario});
    if (!duel.refused.empty()) return duel;
    duel.errors = compare(places, options);
    duel.times = compare_times(seconds, options);
    return duel;
  }

 private:
  static void weigh(const Bench& bench, const std::string& place, const std::string& scenario, statistics::Place& of) {
    of.weight = bench.weights.at(bench.weights_of_scenarios ? scenario : place);
    if (bench.weights_of_scenarios) of.stratum = scenario;
  }

  /// What can run nowhere there is not worse than the other one: there is nothing of it.
  void refuse_what_never_ran(const std::string* place, Duel& duel) const {
    std::size_t cells = 0, first = 0, second = 0;
    for (const auto& [name, twins] : twins_)
      for (const auto& [a, b] : twins)
        if (!place || name == *place) ++cells, first += !a->planned, second += !b->planned;
    if (cells == 0 || (first < cells && second < cells)) return;
    duel.never_ran = true;
    duel.refused = (first < cells ? second_ : second < cells ? first_ : first_ + " and " + second_) + " did not run";
  }

  /// How many seeds these are where each alternative, with whatever else varies held, gave the same with all of them;
  /// else 0. Where one of them always fails, the other one tells.
  static std::size_t seeds_of_one_trial(const std::vector<Twin>& twins) {
    std::map<std::map<std::string, std::string>, std::vector<const Cell*>> alike;
    std::set<std::uint64_t> seeds;
    for (const auto& [a, b] : twins)
      for (const Cell* cell : {a, b})
        if (cell->has_run()) alike[cell->choices].push_back(cell), seeds.insert(cell->seed);
    bool any = false;
    for (const auto& [choices, cells] : alike) {
      const bool silent = std::all_of(cells.begin(), cells.end(), [](const Cell* c) { return c->status == "failed"; });
      if (!silent && !are_one_trial(cells)) return 0;
      any |= !silent;
    }
    return any && seeds.size() > 1 ? seeds.size() : 0;
  }

  static std::vector<Twin> twins_of_one_seed(const std::vector<Twin>& twins) {
    std::vector<Twin> kept;
    for (const Twin& twin : twins)
      if (twin.first->seed == twins.front().first->seed) kept.push_back(twin);
    return kept;
  }

  /// One for each seed: what else varies (other groups) is averaged within it, because it is the same site.
  std::vector<Encounter> encounters(const std::vector<Twin>& twins, Duel& duel, std::vector<TimePair>& seconds) const {
    struct Sum {
      double first = 0, second = 0, both = 0, only_first = 0, only_second = 0, cells = 0;
    };
    std::map<std::uint64_t, Sum> by_seed;
    const std::set<std::string> nodes(group_.nodes.begin(), group_.nodes.end());
    for (const auto& [a, b] : twins) {
      if (!a->has_run() || !b->has_run()) continue;
      const bool first_done = a->status == "done", second_done = b->status == "done";
      Sum& sum = by_seed[a->seed];
      ++sum.cells;
      // An answer that is off by decimetres where millimetres were asked for is no merit before none at all.
      sum.only_first += first_done && !second_done && !(a->error_size() > useless_above_);
      sum.only_second += second_done && !first_done && !(b->error_size() > useless_above_);
      if (!first_done || !second_done) continue;
      refuse_other_starts(*a, *b, duel);
      sum.first += a->measure("error") * a->measure("error");
      sum.second += b->measure("error") * b->measure("error");
      ++sum.both;
      if (a->run != b->run) {  // another hour, perhaps another machine
        duel.times_apart = true;
        continue;
      }
      seconds.push_back(
          {a->seed, seconds_in(*a, nodes, group_.whole_pipelines), seconds_in(*b, nodes, group_.whole_pipelines)});
    }
    std::vector<Encounter> list;
    for (const auto& [seed, sum] : by_seed)  // nan where there was no pair
      list.push_back(
          {seed, sum.first / sum.both, sum.second / sum.both, sum.only_first / sum.cells, sum.only_second / sum.cells});
    return list;
  }

  /// Costs that the bench computed are those of one node. Alternatives before it are compared by where they make it
  /// start, and whole pipelines have costs of different problems.
  static bool costs_count(const Bench& bench, const Group& group) {
    if (bench.judged.empty()) return true;
    return !group.whole_pipelines && std::any_of(group.nodes.begin(), group.nodes.end(), [&](const std::string& node) {
      return std::find(bench.judged.begin(), bench.judged.end(), node) != bench.judged.end();
    });
  }

  /// Inputs that kinds of a role may lack: one takes photographs, the other a scan of the same facade.
  static bool same_where_both_have_them(const std::string& node, const Cell& a, const Cell& b) {
    return std::all_of(a.inputs.begin(), a.inputs.end(), [&](const auto& input) {
      if (input.first.rfind(node + ".", 0) != 0) return true;
      const auto other = b.inputs.find(input.first);
      return other == b.inputs.end() || other->second == input.second;
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
      same |= of_a->second == of_b->second && same_where_both_have_them(node, a, b);
    }
    if (known && !same)
      duel.refused = "what they started from differs in seed " + std::to_string(a.seed) + ": their node '" +
                     group_.nodes.front() + "' did not get the same inputs";
  }

  const Group& group_;
  const bool costs_count_;
  const double useless_above_;  // [m]
  const std::string first_, second_;
  std::map<std::string, std::vector<Twin>> twins_;  // by place
};

std::string time_in_words(const Duel& duel) {
  const auto& ratio = duel.times.ratio;
  if (!std::isfinite(ratio.interval.lower))
    return duel.times_apart ? "their times are of different runs, so they are not compared" : "";
  if (!duel.times.confirmed)
    return "no difference in time is confirmed (ratio " + text::format_fixed(ratio.value, 2) + ", " +
           text::format_fixed(ratio.interval.lower, 2) + " to " + text::format_fixed(ratio.interval.upper, 2) + ")";
  const bool faster = ratio.value < 1;
  const double factor = faster ? 1 / ratio.value : ratio.value;
  const double low = faster ? 1 / ratio.interval.upper : ratio.interval.lower,
               high = faster ? 1 / ratio.interval.lower : ratio.interval.upper;
  return (faster ? duel.first : duel.second) + " is " + text::format_fixed(factor, 2) + " × faster (" +
         text::format_fixed(low, 2) + " to " + text::format_fixed(high, 2) + ")";
}

void put_in_words(Duel& duel, double rope) {
  if (!duel.refused.empty()) {
    duel.words = duel.first + " and " + duel.second + " are not compared: " + duel.refused;
    return;
  }
  if (duel.repeated > 0) {
    duel.words = "nothing can be said of " + duel.first + " and " + duel.second + ": all " +
                 std::to_string(duel.repeated) + " seeds gave the same, so they are one trial";
    return;
  }
  if (!duel.overall || duel.weighted) duel.words = in_words(duel.errors, duel.first, duel.second, rope, 1e3, "mm");
  duel.time_words = time_in_words(duel);
}

std::vector<Duel> duels_of(const Bench& bench, const statistics::InferenceOptions& options) {
  std::vector<Duel> duels;
  const std::vector<std::string> places = bench.places();
  for (const Group& group : bench.groups) {
    std::vector<std::string> names = group.alternatives;
    std::sort(names.begin(), names.end());  // so that the file's order decides nothing
    for (std::size_t a = 0; a < names.size(); ++a)
      for (std::size_t b = a + 1; b < names.size(); ++b) {
        const DuelBuilder builder(bench, group, names[a], names[b]);
        if (places.size() > 1) duels.push_back(builder.duel(nullptr, bench, options));
        for (const std::string& place : places) duels.push_back(builder.duel(&place, bench, options));
      }
  }
  return duels;
}

/// All verdicts of a bench are one family, so that in one of twenty at most a winner is named that is none. Where the
/// file states weights, half of that goes to the answers over all places, however many places there are.
void judge_all(std::vector<Duel>& duels, double rope, double confidence) {
  std::vector<statistics::PairedComparison> family;
  std::vector<double> shares;
  const auto judged = [](const Duel& duel) { return duel.refused.empty() && (!duel.overall || duel.weighted); };
  double places = 0, overall = 0;
  for (const Duel& duel : duels)
    if (judged(duel)) (duel.overall ? overall : places) += 1;
  for (const Duel& duel : duels) {
    if (!judged(duel)) continue;
    family.push_back(duel.errors);
    shares.push_back(duel.overall ? places / overall : 1);
  }
  judge(family, rope, confidence, shares);
  std::size_t next = 0;
  for (Duel& duel : duels) {
    if (judged(duel)) duel.errors = family[next++];
    put_in_words(duel, rope);
  }
}

}  // namespace

std::vector<Duel> judged_duels(const Bench& bench, const statistics::InferenceOptions& options) {
  std::vector<Duel> duels = duels_of(bench, options);
  judge_all(duels, bench.rope, options.confidence);
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

}  // namespace plumbline::bench

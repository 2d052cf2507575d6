#include "bench/analysis.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <sstream>
#include <tuple>

#include "geometry/median.hpp"

namespace plumbline::bench {

namespace {

using statistics::Pair;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// Time of the nodes that alternatives change; nan if one of them was taken from the store and so not timed.
double seconds_of(const Cell& cell, const std::set<std::string>& nodes, bool all) {
  double sum = 0;
  std::size_t timed = 0;
  for (const auto& [node, seconds] : cell.seconds)
    if ((all && node != "start_cost" && node != "final_cost") || nodes.count(node)) sum += seconds, ++timed;
  if (timed == 0) return kNan;
  if (!all)
    for (const std::string& node : nodes)
      if (cell.inputs.count(node) && !cell.seconds.count(node)) return kNan;
  return sum;
}

Row row_of(const std::vector<const Cell*>& cells, const Bench& bench, const statistics::ResamplingOptions& options) {
  Row row;
  row.place = cells[0]->place;
  row.values = cells[0]->values;
  row.choices = cells[0]->choices;
  row.name = choices_text(row.choices);
  std::vector<statistics::Trial> trials;
  std::vector<double> seconds, starts, costs;
  std::size_t failures = 0;
  for (const Cell* cell : cells) {
    row.missing += cell->status == "missing";
    failures += cell->status == "failed";
    if (cell->status != "done") continue;
    trials.push_back({cell->measure("error"), cell->measure("bias"), cell->measure("worst"), cell->measure("predicted"),
                      cell->measure("bound"), cell->measure("nees"), cell->measure("freedom")});
    row.errors.push_back(trials.back().rms);
    row.worst.push_back(trials.back().worst);
    row.seeds.push_back(cell->seed);
    if (const double s = seconds_of(bench, *cell); std::isfinite(s)) seconds.push_back(s);
    if (const double c = cell->measure("start_cost"); std::isfinite(c)) starts.push_back(c);
    if (const double c = cell->measure("final_cost"); std::isfinite(c)) costs.push_back(c);
  }
  row.summary = summarise(trials, failures, bench.tolerances, options);
  row.seconds = median(seconds);
  row.start_cost = median(starts);
  row.final_cost = median(costs);
  return row;
}

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
      seconds.push_back({seconds_of(*a, nodes, group_.whole_pipelines), seconds_of(*b, nodes, group_.whole_pipelines)});
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

std::string fixed(double value, int decimals) {
  char text[64];
  std::snprintf(text, sizeof text, "%.*f", decimals, value);
  return text;
}

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

std::vector<Failure> failures_of(const Bench& bench) {
  std::vector<Failure> failures;
  for (const Cell& cell : bench.cells) {
    if (cell.status != "failed") continue;
    const std::string name = choices_text(cell.choices);
    // Numbers and names of points differ from seed to seed; the first words are the reason.
    const auto words = [](const std::string& text) {
      std::istringstream stream(text);
      std::string kept;
      int count = 0;
      for (std::string word; count < 14 && stream >> word;)
        if (word.find_first_of("0123456789") == std::string::npos) kept += word + " ", ++count;
      return kept;
    };
    auto found = std::find_if(failures.begin(), failures.end(), [&](const Failure& f) {
      return f.place == cell.place && f.name == name && words(f.reason) == words(cell.error);
    });
    if (found == failures.end()) found = failures.insert(failures.end(), {cell.place, name, cell.error, 0, {}});
    ++found->cells;
    found->seeds.push_back(cell.seed);
  }
  return failures;
}

std::vector<std::string> unused_of(const Bench& bench) {
  std::vector<std::string> unused;
  for (const Group& group : bench.groups)
    for (const std::string& name : group.alternatives) {
      std::size_t cells = 0, done = 0;
      std::string reason;
      for (const Cell& cell : bench.cells) {
        const auto choice = cell.choices.find(group.name);
        if (choice == cell.choices.end() || choice->second != name) continue;
        ++cells;
        done += cell.status == "done";
        if (cell.status == "failed" && reason.empty()) reason = cell.error;
      }
      if (done > 0) continue;
      unused.push_back(group.name + "=" + name + " gave no result: " +
                       (cells == 0       ? "all its cells are excluded"
                        : reason.empty() ? "none of its " + std::to_string(cells) + " cells has run yet"
                                         : "all that ran failed; the first: " + reason));
    }
  const bool any_done =
      std::any_of(bench.cells.begin(), bench.cells.end(), [](const Cell& cell) { return cell.status == "done"; });
  for (const auto& [quantity, metric] : bench.metrics) {
    const bool measured = std::any_of(bench.cells.begin(), bench.cells.end(),
                                      [&](const Cell& cell) { return std::isfinite(cell.measure(quantity)); });
    if (any_done && !measured)
      unused.push_back("measure " + quantity + " (" + metric +
                       ") has no value in any finished cell: is it spelt right?");
  }
  return unused;
}

}  // namespace

double seconds_of(const Bench& bench, const Cell& cell) {
  std::set<std::string> nodes;
  bool whole = bench.groups.empty();
  for (const Group& group : bench.groups) {
    nodes.insert(group.nodes.begin(), group.nodes.end());
    whole |= group.whole_pipelines;
  }
  return seconds_of(cell, nodes, whole);
}

Analysis analyse(const Bench& bench) {
  Analysis analysis;
  statistics::ResamplingOptions options;
  options.confidence = analysis.confidence;
  std::vector<std::pair<std::string, std::string>> order;
  std::map<std::pair<std::string, std::string>, std::vector<const Cell*>> by_row;
  std::set<std::uint64_t> seeds;
  for (const Cell& cell : bench.cells) {
    const std::pair<std::string, std::string> key{cell.place, choices_text(cell.choices)};
    auto& cells = by_row[key];
    if (cells.empty()) order.push_back(key);
    cells.push_back(&cell);
    ++analysis.cells;
    analysis.done += cell.status == "done";
    analysis.failed += cell.status == "failed";
    analysis.missing += cell.status == "missing";
    seeds.insert(cell.seed);
  }
  analysis.seeds = seeds.size();
  for (const auto& key : order) analysis.rows.push_back(row_of(by_row[key], bench, options));
  analysis.duels = duels_of(bench, options);
  judge_family(analysis.duels, true, bench.rope, analysis.confidence);
  judge_family(analysis.duels, false, bench.rope, analysis.confidence);
  analysis.failures = failures_of(bench);
  analysis.unused = unused_of(bench);
  return analysis;
}

std::vector<std::string> verdicts(const Bench& bench, const Analysis& analysis) {
  std::vector<std::string> sentences;
  const bool several = bench.places().size() > 1;
  for (std::size_t i = 0; i < analysis.duels.size(); ++i) {
    const Duel& duel = analysis.duels[i];
    if (several && !duel.overall) continue;
    std::string text = several ? "Over all places " + duel.words : duel.words;
    if (several) {
      std::map<std::string, std::vector<std::string>> elsewhere;  // verdict of places that say something else
      for (std::size_t k = i + 1; k < analysis.duels.size() && !analysis.duels[k].overall; ++k) {
        const Duel& place = analysis.duels[k];
        if (!place.refused.empty() || place.errors.verdict == duel.errors.verdict) continue;
        const auto& errors = place.errors;
        const std::string what = errors.verdict == statistics::Verdict::first_better    ? place.first + " is better"
                                 : errors.verdict == statistics::Verdict::second_better ? place.second + " is better"
                                 : errors.verdict == statistics::Verdict::equal         ? "they are equal"
                                 : errors.verdict == statistics::Verdict::undecided     ? "there is no winner"
                                                                                        : "there are too few trials";
        const bool winner =
            errors.verdict == statistics::Verdict::first_better || errors.verdict == statistics::Verdict::second_better;
        elsewhere[what].push_back(place.place +
                                  (winner ? " (by " + fixed(1e3 * std::abs(errors.difference.value), 2) + " mm)" : ""));
      }
      const std::size_t places = bench.places().size();
      for (const auto& [what, where] : elsewhere) {
        if (where.size() == places && what == "there are too few trials") {
          text += "; there are too few trials for any single place";
          continue;
        }
        text += "; " + what + " on ";
        for (std::size_t k = 0; k < where.size(); ++k) text += (k ? " / " : "") + where[k];
      }
    }
    sentences.push_back(text + ".");
  }
  return sentences;
}

std::vector<std::string> choices_to_make(const Bench& bench, const Analysis& analysis) {
  std::vector<std::string> sentences;
  const std::size_t places = bench.places().size();
  for (const Group& group : bench.groups) {
    struct Standing {
      std::vector<std::string> beaten_on;
      double most = 0;     // largest difference by which it is beaten [m]
      double overall = 0;  // largest over all places together [m]
      std::size_t cells = 0, failed = 0;
      bool compared = false;  // with enough trials for a verdict
    };
    std::map<std::string, Standing> standings;
    for (const Duel& duel : analysis.duels) {
      if (duel.group != group.name || !duel.refused.empty()) continue;
      if (duel.errors.verdict != statistics::Verdict::too_few)
        standings[duel.first].compared = standings[duel.second].compared = true;
      const bool first_loses = duel.errors.verdict == statistics::Verdict::second_better;
      if (!first_loses && duel.errors.verdict != statistics::Verdict::first_better) continue;
      Standing& loser = standings[first_loses ? duel.first : duel.second];
      if (duel.overall) {
        loser.overall = std::max(loser.overall, std::abs(duel.errors.difference.value));
        continue;
      }
      if (std::find(loser.beaten_on.begin(), loser.beaten_on.end(), duel.place) == loser.beaten_on.end())
        loser.beaten_on.push_back(duel.place);
      loser.most = std::max(loser.most, std::abs(duel.errors.difference.value));
    }
    for (const Cell& cell : bench.cells) {
      const auto choice = cell.choices.find(group.name);
      if (choice == cell.choices.end() || cell.status == "missing") continue;
      ++standings[choice->second].cells;
      standings[choice->second].failed += cell.status == "failed";
    }
    std::string text = group.name + ":";
    for (const std::string& name : group.alternatives) {
      const Standing& s = standings[name];
      if (s.cells == 0) continue;
      text += text.back() == ':' ? " " : "; ";
      if (s.failed == s.cells) {
        text += name + " gave no result in any of " + std::to_string(s.cells) + " cells";
        continue;
      }
      if (!s.compared)
        text += "of " + name + " nothing can be said: too few trials to compare it";
      else if (s.overall > 0)
        text += name + " is beaten by " + fixed(1e3 * s.overall, 2) + " mm over all places together, and on " +
                std::to_string(s.beaten_on.size()) + " of " + std::to_string(places) + " by itself";
      else if (s.beaten_on.empty())
        text += name + " is beaten nowhere";
      else if (places == 1)
        text += name + " is beaten by " + fixed(1e3 * s.most, 2) + " mm";
      else
        text += name + " is beaten on " + std::to_string(s.beaten_on.size()) + " of " + std::to_string(places) +
                " places, by " + fixed(1e3 * s.most, 2) + " mm at most";
      if (s.failed > 0)
        text += ", without result in " + std::to_string(s.failed) + " of " + std::to_string(s.cells) + " cells";
    }
    sentences.push_back(text + ".");
  }
  return sentences;
}

}  // namespace plumbline::bench

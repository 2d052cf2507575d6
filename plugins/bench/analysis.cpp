#include "bench/analysis.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>

#include "bench/duels.hpp"
#include "geometry/median.hpp"

namespace plumbline::bench {

namespace {

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
  return seconds_in(cell, nodes, whole);
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
  analysis.duels = judged_duels(bench, options, analysis.confidence);
  analysis.failures = failures_of(bench);
  analysis.unused = unused_of(bench);
  return analysis;
}

std::vector<std::string> verdicts(const Bench& bench, const Analysis& analysis) {
  std::vector<std::string> sentences;
  const bool several = bench.places().size() > 1;
  std::set<std::pair<std::string, std::string>> with_result;
  for (const Cell& cell : bench.cells)
    if (cell.status == "done") with_result.insert(cell.choices.begin(), cell.choices.end());
  for (std::size_t i = 0; i < analysis.duels.size(); ++i) {
    const Duel& duel = analysis.duels[i];
    if (several && !duel.overall) continue;
    // Who gave no result at all is told of by itself, once, and not against everybody else.
    if (with_result.count({duel.group, duel.first}) == 0 || with_result.count({duel.group, duel.second}) == 0) continue;
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

#include "show/bench/analysis.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>

#include "geometry/median.hpp"
#include "show/bench/duels.hpp"
#include "show/bench/pairing.hpp"

namespace plumbline::bench {

namespace {

Row row_of(const std::vector<const Cell*>& cells, const Bench& bench, double confidence) {
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
    row.unplanned += !cell->planned;
    failures += cell->status == "failed" && cell->planned;
    if (cell->status != "done") continue;
    trials.push_back({cell->error_size(),
                      cell->measure("bias"),
                      std::abs(cell->measure("worst")),
                      cell->measure("predicted"),
                      cell->measure("bound"),
                      cell->measure("nees"),
                      cell->measure("freedom"),
                      {}});
    for (const auto& [mode, stated] : cell->modes)
      trials.back().modes[mode] = {stated.at("found"), stated.at("predicted"), stated.at("nees"), stated.at("freedom")};
    row.errors.push_back(trials.back().rms);
    row.worst.push_back(trials.back().worst);
    row.seeds.push_back(cell->seed);
    if (const double s = seconds_of(bench, *cell); std::isfinite(s)) seconds.push_back(s);
    if (const double c = cell->measure("start_cost"); std::isfinite(c)) starts.push_back(c);
    if (const double c = cell->measure("final_cost"); std::isfinite(c)) costs.push_back(c);
  }
  if (are_one_trial(cells)) trials.resize(1);  // no interval can come from running it again
  row.summary = summarise(trials, failures, bench.tolerances, confidence);
  row.seconds = median(seconds);
  row.start_cost = median(starts);
  row.final_cost = median(costs);
  return row;
}

/// Errors of rows are compared by eye, whatever the verdicts are of.
void mark_own_trials(std::vector<Row>& rows) {
  for (Row& row : rows)
    row.own_trials = std::any_of(rows.begin(), rows.end(), [&](const Row& other) {
      const auto sorted = [](std::vector<std::uint64_t> seeds) {
        std::sort(seeds.begin(), seeds.end());
        return seeds;
      };
      return other.place == row.place && !row.seeds.empty() && !other.seeds.empty() &&
             sorted(other.seeds) != sorted(row.seeds);
    });
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

/// A measure without a value in any finished cell, or in some of them only: a mean over the others would be one of
/// other trials, so rows with such a cell have none.
void add_unmeasured(const Bench& bench, const std::string& quantity, const std::string& metric,
                    std::vector<std::string>& unused) {
  std::size_t done = 0, without = 0;
  std::set<std::pair<std::string, std::string>> rows, half;
  const Cell* first = nullptr;
  for (const Cell& cell : bench.cells) {
    if (cell.status != "done") continue;
    ++done;
    const std::pair<std::string, std::string> row{cell.place, choices_text(cell.choices)};
    if (std::isfinite(cell.measure(quantity))) {
      rows.insert(row);
      continue;
    }
    ++without;
    half.insert(row);
    if (!first) first = &cell;
  }
  const std::string measure = "measure " + quantity + " (" + metric + ") has no value in ";
  if (done > 0 && without == done) unused.push_back(measure + "any finished cell: is it spelt right?");
  if (without == 0 || without == done) return;
  // Alternatives that do not measure it at all are no surprise; one that does in some trials is.
  std::erase_if(half, [&](const auto& row) { return rows.count(row) == 0; });
  if (half.empty()) return;
  const std::string example = half.begin()->second.empty() ? "" : half.begin()->second;
  const std::string at = half.begin()->first + (half.begin()->first.empty() || example.empty() ? "" : ", ") + example;
  unused.push_back(measure + "some trials of " + std::to_string(half.size()) + (half.size() == 1 ? " row" : " rows") +
                   (at.empty() ? "" : " (the first: " + at + ")") + ", which therefore have none");
}

/// Sets Duel::untested at each place, and over all of them where every place that is won for want of results is so.
void mark_untested(const Bench& bench, const std::vector<Row>& rows, std::vector<Duel>& duels) {
  const auto for_results = [](const Duel& duel) {
    return duel.refused.empty() && is_winner(duel.errors.verdict) && !duel.errors.errors_differ;
  };
  for (Duel& duel : duels) {
    if (duel.overall || !for_results(duel)) continue;
    const bool first = duel.errors.verdict == statistics::Verdict::first_better;
    const auto lost = lost_cells(bench, duel, first ? duel.second : duel.first);
    const auto forbidden = std::count_if(lost.begin(), lost.end(), [](const Cell* cell) { return cell->forbidden; });
    duel.untested = 2 * forbidden > static_cast<std::ptrdiff_t>(lost.size()) &&
                    stated_of(rows, duel, first ? duel.first : duel.second) != Stated::holds;
  }
  for (Duel& all : duels) {
    if (!all.overall || !for_results(all)) continue;
    std::size_t won = 0, untested = 0;
    for (const Duel& duel : duels)
      if (!duel.overall && duel.group == all.group && duel.first == all.first && duel.second == all.second &&
          for_results(duel) && duel.errors.verdict == all.errors.verdict)
        ++won, untested += duel.untested;
    all.untested = won > 0 && untested == won;
  }
  for (Duel& duel : duels)
    if (duel.untested && !duel.words.empty())
      duel.words += "; most of these the other one's own test forbids, so more results are no merit";
}

std::vector<std::string> unused_of(const Bench& bench) {
  std::vector<std::string> unused;
  for (const Group& group : bench.groups)
    for (const std::string& name : group.alternatives) {
      std::size_t cells = 0, done = 0, unplanned = 0;
      std::string reason;
      for (const Cell& cell : bench.cells) {
        const auto choice = cell.choices.find(group.name);
        if (choice == cell.choices.end() || choice->second != name) continue;
        ++cells;
        done += cell.status == "done", unplanned += !cell.planned;
        if (cell.status == "failed" && reason.empty()) reason = cell.error;
      }
      if (done > 0) continue;
      unused.push_back(group.name + "=" + name + " gave no result: " +
                       (cells == 0 ? "all its cells are excluded"
                        : unplanned == cells && !reason.empty()
                            ? "it did not run, because no pipeline can be made of any of its " + std::to_string(cells) +
                                  " cells; the first: " + reason
                        : reason.empty() ? "none of its " + std::to_string(cells) + " cells has run yet"
                                         : "all that ran failed; the first: " + reason));
    }
  for (const auto& [quantity, metric] : bench.metrics) add_unmeasured(bench, quantity, metric, unused);
  return unused;
}

/// evaluate.cost counts everything that was observed, also what the alternative rejected or damped: a cost that goes up
/// is one of another problem than the one that was solved, or a solver that diverged, and not seen in a table.
std::vector<std::string> rising_of(const Bench& bench) {
  struct Count {
    std::size_t rose = 0, all = 0;
    double start = 0, final = 0;
  };
  std::map<std::string, Count> counts;
  std::vector<std::string> order, sentences;
  for (const Cell& cell : bench.cells) {
    const double start = cell.measure("start_cost"), final = cell.measure("final_cost");
    if (cell.status != "done" || !std::isfinite(start + final)) continue;
    const std::string name = (cell.place.empty() ? "" : cell.place + ", ") + choices_text(cell.choices);
    const auto [found, fresh] = counts.emplace(name, Count{});
    if (fresh) order.push_back(name);
    ++found->second.all;
    if (!(final > start * (1 + 1e-9))) continue;
    if (found->second.rose++ == 0) found->second.start = start, found->second.final = final;
  }
  for (const std::string& name : order) {
    const Count& c = counts.at(name);
    if (c.rose == 0) continue;
    const std::string costs = fmt::format("{:.4g} to {:.4g}", c.start, c.final);
    sentences.push_back(name + ": the cost of all observations went up in " + std::to_string(c.rose) + " of " +
                        std::to_string(c.all) + " trials (the first from " + costs +
                        "): what was minimised leaves some of them out or damps them, or the solver diverged");
  }
  return sentences;
}

/// Places where the seed changes nothing, in words; where it does for others, whose seeds are one trial.
std::vector<std::string> repeated_of(const std::vector<Duel>& duels) {
  std::vector<std::string> sentences;
  for (const Duel& duel : duels) {
    if (duel.overall || duel.repeated == 0) continue;
    const bool all = std::none_of(duels.begin(), duels.end(), [&](const Duel& other) {
      return !other.overall && other.place == duel.place && other.refused.empty() && other.errors.pairs > 1;
    });
    const std::string text =
        "all " + std::to_string(duel.repeated) + " seeds gave the same" +
        (all ? "" : " with " + duel.first + " and with " + duel.second) +
        (duel.place.empty() ? "" : " on " + duel.place) +
        (all ? ": nothing there hangs on the seed, so they are one trial, which no interval and no winner can rest on"
             : ": they are one trial, so no interval and no winner between these two can rest on them");
    if (std::find(sentences.begin(), sentences.end(), text) == sentences.end()) sentences.push_back(text);
  }
  return sentences;
}

}  // namespace

std::vector<const Cell*> lost_cells(const Bench& bench, const Duel& duel, const std::string& loser) {
  const std::string& winner = loser == duel.first ? duel.second : duel.first;
  using Site = std::pair<std::uint64_t, std::map<std::string, std::string>>;  // seed, and what the other groups have
  const double useless_above = bench.useless_above();
  std::set<Site> given;
  std::vector<std::pair<Site, const Cell*>> failed;
  for (const Cell& cell : bench.cells) {
    const auto choice = cell.choices.find(duel.group);
    if (cell.place != duel.place || choice == cell.choices.end() || !cell.has_run()) continue;
    Site site{cell.seed, cell.choices};
    site.second.erase(duel.group);
    if (choice->second == winner && cell.status == "done" && !(cell.error_size() > useless_above)) given.insert(site);
    if (choice->second == loser && cell.status == "failed") failed.emplace_back(site, &cell);
  }
  std::vector<const Cell*> lost;
  for (const auto& [site, cell] : failed)
    if (given.count(site)) lost.push_back(cell);
  return lost;
}

Stated stated_of(const std::vector<Row>& rows, const Duel& duel, const std::string& name) {
  Stated found = Stated::unknown;
  for (const Row& row : rows) {
    const auto choice = row.choices.find(duel.group);
    if (row.place != duel.place || choice == row.choices.end() || choice->second != name) continue;
    const auto& parts = row.summary.calibration;
    const auto all = std::find_if(parts.begin(), parts.end(), [](const auto& part) { return part.mode.empty(); });
    if (all == parts.end()) return Stated::unknown;
    const auto honest = statistics::honesty(*all);
    const bool known = honest != statistics::Honesty::unknown;
    if (!known && !(std::isfinite(all->nees) && std::isfinite(all->nees_band.upper))) return Stated::unknown;
    if (known ? honest == statistics::Honesty::too_little : all->nees > all->nees_band.upper) return Stated::wrong;
    found = Stated::holds;
  }
  return found;
}

bool are_one_trial(const std::vector<const Cell*>& cells) {
  const Cell* first = nullptr;
  std::size_t count = 0;
  for (const Cell* cell : cells) {
    if (!cell->has_run()) continue;
    ++count;
    if (!first) first = cell;
    if (cell->status != first->status) return false;
    if (cell->status != "done") continue;
    // One measure alone may be alike for another reason: nothing wrong, or as wrong as it can be.
    for (const auto& [name, b] : first->measures) {
      const double a = cell->measure(name);
      if (std::isfinite(a) != std::isfinite(b) || std::abs(a - b) > 1e-12 * std::abs(b)) return false;
    }
  }
  return count > 1 && first->status == "done";
}

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
  statistics::InferenceOptions options;
  if (!bench.looks.empty()) analysis.confidence = statistics::confidence_of_a_look(bench.looks.size());
  options.confidence = analysis.confidence;
  std::size_t pairs = 0;
  for (const Group& group : bench.groups) pairs += group.alternatives.size() * (group.alternatives.size() - 1) / 2;
  options.draws = statistics::draws_for(pairs * bench.places().size());
  using Key = std::pair<std::string, std::map<std::string, std::string>>;  // names may have " · " in them
  std::vector<Key> order;
  std::map<Key, std::vector<const Cell*>> by_row;
  std::set<std::uint64_t> seeds;
  for (const Cell& cell : bench.cells) {
    const Key key{cell.place, cell.choices};
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
  for (const auto& key : order) analysis.rows.push_back(row_of(by_row[key], bench, options.confidence));
  mark_own_trials(analysis.rows);
  analysis.duels = judged_duels(bench, options);
  mark_untested(bench, analysis.rows, analysis.duels);
  for (const Duel& duel : analysis.duels)
    analysis.open +=
        (!duel.overall || duel.weighted) && !duel.never_ran &&
        (!duel.refused.empty() || duel.errors.verdict == statistics::Verdict::undecided ||
         duel.errors.verdict == statistics::Verdict::too_few || (duel.untested && !errors_equal(duel, bench.rope)));
  analysis.failures = failures_of(bench);
  analysis.unused = unused_of(bench);
  for (std::string& sentence : repeated_of(analysis.duels)) analysis.unused.push_back(std::move(sentence));
  analysis.rising = rising_of(bench);
  analysis.breakdowns = breakdowns(bench, analysis.confidence);
  return analysis;
}

}  // namespace plumbline::bench

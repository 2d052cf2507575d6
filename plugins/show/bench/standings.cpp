#include "show/bench/standings.hpp"

#include <algorithm>
#include <cmath>

namespace plumbline::bench {

using statistics::Verdict;

namespace {

bool has_verdict(const Duel& duel) { return duel.refused.empty() && duel.errors.verdict != Verdict::too_few; }

/// What the verdicts over all places say, where the file states what a mean over them means.
void add_overall(const std::vector<Pairing>& pairs, Standings& standings) {
  for (const Pairing& pair : pairs) {
    if (!pair.overall || !pair.overall->weighted || !has_verdict(*pair.overall)) continue;
    const auto& errors = pair.overall->errors;
    standings[pair.first()].compared = standings[pair.second()].compared = true;
    if (!is_winner(errors.verdict) || pair.overall->untested) continue;
    const bool first = errors.verdict == Verdict::first_better;
    Standing& loser = standings[first ? pair.second() : pair.first()];
    loser.beaten_overall = true;
    standings[first ? pair.first() : pair.second()].best_overall = true;
    if (errors.errors_differ) loser.most_overall = std::max(loser.most_overall, std::abs(errors.difference.value));
  }
  for (auto& [name, standing] : standings) standing.best_overall &= !standing.beaten_overall;
}

/// Places where nothing of an alternative has run: what is said of it says nothing of them.
void add_untried(const Bench& bench, const Group& group, Standings& standings) {
  std::map<std::string, std::set<std::string>> tried;
  for (const Cell& cell : bench.cells)
    if (const auto choice = cell.choices.find(group.name); choice != cell.choices.end() && cell.has_run())
      tried[choice->second].insert(cell.place);
  for (const std::string& place : bench.places())
    for (const auto& [name, places] : tried)
      if (places.count(place) == 0) standings[name].untried.push_back(place);
}

void add_once(std::vector<std::string>& list, const std::string& name) {
  if (std::find(list.begin(), list.end(), name) == list.end()) list.push_back(name);
}

}  // namespace

Standings standings_of(const Bench& bench, const Group& group, const Analysis& analysis,
                       const std::vector<Pairing>& pairs) {
  Standings standings;
  for (const Pairing& pair : pairs)
    for (const Duel* duel : pair.places) {
      if (!has_verdict(*duel)) continue;
      for (const std::string& name : {duel->first, duel->second})
        standings[name].compared = true, standings[name].compared_on.insert(duel->place);
      if (!is_winner(duel->errors.verdict)) continue;
      const bool first = duel->errors.verdict == Verdict::first_better;
      Standing& loser = standings[first ? duel->second : duel->first];
      if (duel->untested) {
        const std::string& winner = first ? duel->first : duel->second;
        add_once(loser.untested[stated_of(analysis.rows, *duel, winner)], winner);
        loser.untested_on.insert(duel->place);
        for (const Cell* cell : lost_cells(bench, *duel, first ? duel->second : duel->first))
          if (cell->forbidden) loser.forbidden.insert(cell);
        continue;
      }
      add_once(loser.beaten_on, duel->place);
      if (duel->errors.errors_differ) loser.most = std::max(loser.most, std::abs(duel->errors.difference.value));
    }
  add_overall(pairs, standings);
  add_untried(bench, group, standings);
  const double useless_above = bench.useless_above();
  for (const Cell& cell : bench.cells) {
    const auto choice = cell.choices.find(group.name);
    if (choice == cell.choices.end()) continue;
    Standing& standing = standings[choice->second];
    standing.unplanned += !cell.planned;
    if (!cell.has_run()) continue;
    const bool failed = cell.status == "failed", useless = cell.status == "done" && cell.error_size() > useless_above;
    ++standing.cells, ++standing.at[cell.place].cells;
    standing.failed += failed, standing.useless += useless;
    standing.at[cell.place].lost += failed || useless;
  }
  return standings;
}

}  // namespace plumbline::bench

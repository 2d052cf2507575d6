// From cells to what can be said: a summary of each alternative in each place, and each pair of alternatives compared
// on the trials that both finished, everything else held.
#pragma once

#include "base/statistics/comparison.hpp"
#include "base/statistics/trial_summary.hpp"
#include "show/bench/bench_data.hpp"
#include "show/bench/breakdown.hpp"

namespace plumbline::bench {

/// One line of the table: one way to fill all groups, in one place.
struct Row {
  std::string place, name;                    ///< name: its choices in words
  std::map<std::string, std::string> values;  ///< of the matrix
  std::map<std::string, std::string> choices;
  statistics::TrialSummary summary;
  std::size_t missing = 0;                ///< cells that have not run yet
  std::size_t unplanned = 0;              ///< cells that cannot run: no pipeline could be made of them; no trials
  double seconds = 0;                     ///< median over trials, of the nodes that alternatives change; nan: unknown
  double start_cost = 0, final_cost = 0;  ///< medians; nan: not measured
  std::vector<double> errors, worst;      ///< of the finished trials [m]
  std::vector<std::uint64_t> seeds;       ///< theirs
  bool own_trials = false;  ///< another row of the place finished others: then their errors are of different trials
};

struct Duel {
  std::string group, first, second;
  std::string place;       ///< empty for all places together, if there are several
  bool overall = false;    ///< then `errors` has the spread between places
  bool weighted = false;   ///< and, if the file states weights, a mean over them with its verdict
  std::string refused;     ///< why they cannot be compared; empty: they can
  bool never_ran = false;  ///< one of them cannot run there, then `refused` says which
  /// A winner for want of the other's results, which the other's own test forbids, where nothing shows that those of
  /// the winner may be used: its covariance is not known, or does not hold. That is no merit.
  bool untested = false;
  statistics::PairedComparison errors;
  std::size_t repeated = 0;  ///< seeds that all gave the same and are one trial; 0: they do not
  statistics::TimeComparison times;
  bool times_apart = false;  ///< some of the pairs ran in different calls of the program: their times do not count
  std::string words;         ///< the verdict, with what to know beside it
  std::string time_words;    ///< who is faster; empty if nothing was timed
};

struct Failure {
  std::string place, name, reason;
  std::size_t cells = 0;
  std::vector<std::uint64_t> seeds;
};

struct Analysis {
  std::vector<Row> rows;
  std::vector<Duel> duels;  ///< group by group; overall before the places
  std::vector<Failure> failures;
  std::vector<std::string> unused;  ///< alternatives that ran nothing and measures without a value, with the reason
  std::vector<std::string> rising;  ///< rows whose cost went up, in words
  std::vector<Breakdown> breakdowns;
  std::size_t cells = 0, done = 0, failed = 0, missing = 0, seeds = 0;
  std::size_t open = 0;  ///< comparisons that are not decided: too few trials, or nothing shown
  /// Of all intervals and verdicts. Where a bench may stop at several looks each has its share of the 5 % (Bonferroni),
  /// so that stopping when something is shown does not make it be shown too often.
  double confidence = 0.95;
};

Analysis analyse(const Bench& bench);

/// Cells of `loser`, one of the duel's two, at its place that have no result where the other one, all else alike, has
/// one of use.
std::vector<const Cell*> lost_cells(const Bench& bench, const Duel& duel, const std::string& loser);

/// Whether the covariances of an alternative hold at a place: in every row there they do not state too little, in one
/// of them they do, or it is not known. More than what is found is the safe side. By statistics::honesty(), as the
/// tables say it; where nothing is predicted, by whether NEES lies above its band.
enum class Stated { holds, wrong, unknown };
Stated stated_of(const std::vector<Row>& rows, const Duel& duel, const std::string& name);

/// Time of the nodes that alternatives change in a cell [s], without those that only judge; nan if one of them was
/// taken from the store and so not timed.
double seconds_of(const Bench& bench, const Cell& cell);

/// Whether these cells of one alternative at one place are one trial that was run several times: two or more, and all
/// ended alike with the same error to the last digits. Then nothing in the pipeline hangs on the seed.
bool are_one_trial(const std::vector<const Cell*>& cells);

}  // namespace plumbline::bench

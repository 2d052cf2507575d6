// From cells to what can be said: a summary of each alternative in each place, and each pair of alternatives compared
// on the trials that both finished, everything else held.
#pragma once

#include "bench/bench_data.hpp"
#include "statistics/comparison.hpp"
#include "statistics/trial_summary.hpp"

namespace plumbline::bench {

/// One line of the table: one way to fill all groups, in one place.
struct Row {
  std::string place, name;                    ///< name: its choices in words
  std::map<std::string, std::string> values;  ///< of the matrix
  std::map<std::string, std::string> choices;
  statistics::TrialSummary summary;
  std::size_t missing = 0;                ///< cells that have not run yet
  double seconds = 0;                     ///< median over trials, of the nodes that alternatives change; nan: unknown
  double start_cost = 0, final_cost = 0;  ///< medians; nan: not measured
  std::vector<double> errors, worst;      ///< of the finished trials [m]
  std::vector<std::uint64_t> seeds;       ///< theirs
};

struct Duel {
  std::string group, first, second;
  std::string place;  ///< empty for all places together, if there are several
  bool overall = false;
  std::string refused;                          ///< why they cannot be compared; empty: they can
  std::size_t only_first = 0, only_second = 0;  ///< trials that only one of them finished
  statistics::PairedComparison errors;
  statistics::TimeComparison times;
  std::string words;  ///< the verdict, with what to know beside it
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
  std::size_t cells = 0, done = 0, failed = 0, missing = 0, seeds = 0;
  double confidence = 0.95;
};

Analysis analyse(const Bench& bench);

/// Time of the nodes that alternatives change in a cell [s], without those that only judge; nan if one of them was
/// taken from the store and so not timed.
double seconds_of(const Bench& bench, const Cell& cell);

/// What one should know first, a sentence each: per pair of alternatives the verdict over all places and where it
/// differs.
std::vector<std::string> verdicts(const Bench& bench, const Analysis& analysis);

/// What a practitioner may choose, a sentence for each group: which alternatives are beaten nowhere, which are beaten
/// where and by how much at most, and which gave no result how often.
std::vector<std::string> choices_to_make(const Bench& bench, const Analysis& analysis);

}  // namespace plumbline::bench

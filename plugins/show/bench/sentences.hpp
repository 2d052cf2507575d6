// What a bench says in words: a sentence for each group that a person would say aloud, and the verdicts behind it.
#pragma once

#include "show/bench/analysis.hpp"

namespace plumbline::bench {

struct Sentence {
  std::string text;
  bool winner = false;   ///< somebody is better somewhere
  bool open = false;     ///< nothing is shown
  bool refused = false;  ///< they are not compared
};

/// Per pair of alternatives where which is better, how the difference varies between places, and, with weights that the
/// file states, the verdict over all of them.
std::vector<Sentence> verdicts(const Bench& bench, const Analysis& analysis);

/// What a practitioner may choose, a sentence for each group: who is beaten nowhere and whom it beats where, that
/// nothing separates them, or that each is best somewhere.
std::vector<std::string> choices_to_make(const Bench& bench, const Analysis& analysis);

/// Whose covariance states what is found and whose does not, in which part of the errors; one sentence an alternative
/// that states something wrong somewhere, and one that counts those that are right.
std::vector<std::string> calibration_verdicts(const Analysis& analysis);

/// Of the intervals: "95 %", or less of an error probability where the bench may stop at several looks.
std::string confidence_text(const Bench& bench, const Analysis& analysis);

/// How intervals and tests were made.
std::string method_text(const Bench& bench, const Analysis& analysis);

/// "*" at the errors of a row that are of other trials than those of another row beside it; method_text() says so.
std::string own_trials_mark(const Row& row);

}  // namespace plumbline::bench

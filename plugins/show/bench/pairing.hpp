// Two alternatives of a bench with all that is known of them, and the words that sentences about them share.
#pragma once

#include <string>
#include <vector>

#include "show/bench/analysis.hpp"
#include "show/bench/duels.hpp"

namespace plumbline::bench {

/// All that is known of two alternatives.
struct Pairing {
  const Duel* overall = nullptr;
  std::vector<const Duel*> places;
  std::string first() const { return places.front()->first; }
  std::string second() const { return places.front()->second; }
};

std::vector<Pairing> pairings(const Analysis& analysis, const std::string& group);

inline bool is_winner(statistics::Verdict v) {
  return v == statistics::Verdict::first_better || v == statistics::Verdict::second_better;
}

/// Whether the errors of the trials that both finished are shown to differ by less than the rope [m], whatever the
/// verdict rests on.
bool errors_equal(const Duel& duel, double rope);

/// Every trial gave both the same; false if one of them failed where the other did not.
bool all_same(const Pairing& pair);

/// "131 seeds would show 0.06 mm on full height": of the place that needs most. Empty where nothing is open.
std::string power_text(const Pairing& pair, const Bench& bench);

/// "a / b": names of places have commas in them.
std::string listed(const std::vector<std::string>& places);
std::string millimetres(double metres);  ///< of its absolute value
std::string rope_text(const Bench& bench);
/// With a capital letter, but for kinds of nodes, which stay as they are written ("adjust.schur"), and for what begins
/// with one of `names`: "gut" and "Gut" may be two alternatives.
std::string begin_sentence(std::string text, const std::vector<std::string>& names = {});

}  // namespace plumbline::bench

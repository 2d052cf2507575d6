// Which of two alternatives is better on the same trials, by how much, and whether that matters.
#pragma once

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "base/statistics/by_seed.hpp"

namespace plumbline::statistics {

/// What one seed gave two alternatives at one place. What else varies there (other groups) is one site, so its cells
/// are averaged.
struct Encounter {
  std::uint64_t seed = 0;
  double first = 0, second = 0;            ///< mean square errors over the cells that both finished; nan without any
  double only_first = 0, only_second = 0;  ///< share of the cells that one finished and the other did not
};

struct Place {
  double weight = 1;  ///< in what is said over all places; above zero
  std::vector<Encounter> encounters;
  std::string stratum = {};  ///< those of its places that count share its weight alike; empty: a place of its own
};

enum class Verdict {
  first_better,   ///< smaller errors, or a result where the other has none; see judge()
  second_better,  ///< likewise
  equal,          ///< the difference is shown to be smaller than the rope
  undecided,      ///< neither is shown
  opposed,        ///< one has the smaller errors, the other gives a result more often
  too_few         ///< not enough pairs for any interval
};
const char* to_text(Verdict verdict);

/// Differences between places that go beyond what their noise explains.
struct Spread {
  std::size_t places = 0;
  double deviation = 0;  ///< standard deviation between places; moments, with the covariance that shared seeds give
  double lowest = 0, highest = 0;  ///< difference of one place
};

struct PairedComparison {
  std::size_t seeds = 0;            ///< different ones among the pairs
  std::size_t pairs = 0;            ///< of a seed and a place where both finished
  std::size_t places = 0;           ///< with least_seeds pairs or more: those that count
  std::size_t left_out = 0;         ///< places with fewer
  std::vector<std::string> silent;  ///< strata of which no place counts: then nothing is said of the mean of errors
  double first = 0, second = 0;     ///< RMSE of each over the pairs, the weighted mean over places; nan without any
  Estimate difference;              ///< first minus second
  Interval narrow;                  ///< with 1 - 2 (1 - confidence): two one-sided tests (Schuirmann 1987) use it
  double deviation = 0;             ///< of the difference, by one seed
  bool same = false;                ///< all errors agree to 1e-9 of themselves: nothing that was compared was measured
  Estimate improvement;   ///< probability that the first does better on a trial; no result loses, ties are half
  double p = 0;           ///< exchange test of the difference
  double adjusted_p = 0;  ///< after judge(); before it, equal to p
  double lost_first = 0, lost_second = 0;  ///< trials (cells of a seed as shares) that only the other one finished
  double share_lost = 0;                   ///< weighted mean over places: first minus second, of all trials
  double p_lost = std::nan(""),
         adjusted_p_lost = std::nan("");  ///< exchange test of share_lost; nan with fewer than least_seeds such seeds
  std::optional<Spread> spread;           ///< with two places or more that count
  bool errors_differ = false;             ///< after judge(): the verdict rests on the errors, not on failures alone
  double risk = 0;                        ///< after judge(): the level at which a first test of the family is made
  Verdict verdict = Verdict::too_few;
};

/// Difference of RMSE in each place that has least_seeds pairs, and its weighted mean over those places. Intervals,
/// tests and deviations take a seed in all places at once. Where a stratum has no such place, its weight would go to
/// the others without a word, so the errors are not compared; nor are failures where it has no trials at all.
PairedComparison compare(const std::vector<Place>& places, const InferenceOptions& options);

/// Of intervals and verdicts at each of several looks at which one may stop, so that all of them together err in 5 % at
/// most (Bonferroni): 1 - 0.05 / looks. `looks` ≥ 1.
inline double confidence_of_a_look(std::size_t looks) { return 1 - 0.05 / static_cast<double>(looks); }

/// Adjusts the p of all comparisons as one family and gives the verdicts. A difference whose whole interval lies within
/// the rope is `equal` even if it is significant: it does not matter. `rope` is in the unit of the errors; 0: never
/// equal. `shares` of the error probability as in holm().
///
/// A failure is a loss: where one of them gives significantly more results, it is better, unless its errors are
/// significantly larger, then they are `opposed`.
void judge(std::vector<PairedComparison>& family, double rope, double confidence,
           const std::vector<double>& shares = {});

/// "constrained beats registered by 0.14 mm (0.09 to 0.20)", "equal within 0.05 mm", ... and what to know beside it:
/// failures, places left out, seeds that would show the rope. `scale` turns the errors' unit into the one printed.
std::string in_words(const PairedComparison& comparison, const std::string& first, const std::string& second,
                     double rope, double scale, const std::string& unit);

/// Seeds with which a difference as large as the one found, or as the rope if that is larger, is shown in four of five
/// benches at the level that the family leaves; nan where something is shown already.
double seeds_wanted(const PairedComparison& comparison, double rope);

/// "140 seeds would show 0.05 mm"; empty where those that are there do, or nothing is known.
std::string power_in_words(const PairedComparison& comparison, double rope, double scale, const std::string& unit);

/// Times of one seed.
struct TimePair {
  std::uint64_t seed = 0;
  double first = 0, second = 0;
};
/// Median of the ratios first / second of paired times, with a percentile interval from whole seeds drawn, and the same
/// for each half of the seeds taken by turns: a difference counts as confirmed if all three intervals lie on one side
/// of 1.
struct TimeComparison {
  std::size_t pairs = 0;
  Estimate ratio;
  Interval halves[2];
  bool confirmed = false;
};
TimeComparison compare_times(const std::vector<TimePair>& seconds, const InferenceOptions& options);

}  // namespace plumbline::statistics

// Which of two alternatives is better on the same trials, by how much, and whether that matters.
#pragma once

#include <string>
#include <vector>

#include "statistics/resampling.hpp"

namespace plumbline::statistics {

/// One trial that both alternatives finished.
struct Pair {
  double first = 0, second = 0;  ///< mean square errors of the trial, in the square of the error's unit
};

enum class Verdict {
  first_better,  ///< the interval of the difference lies below zero, and so does Holm's adjusted p below 1 - confidence
  second_better,  ///< likewise above zero
  equal,          ///< the difference is shown to be smaller than the rope
  undecided,      ///< the interval covers zero and reaches beyond the rope
  too_few         ///< not enough pairs for any interval
};
const char* to_text(Verdict verdict);

/// With fewer pairs even the clearest result has a two-sided p above 0.05 (2 / 2^5).
constexpr std::size_t least_pairs = 6;

struct PairedComparison {
  std::size_t pairs = 0;
  std::size_t fewest = 0;        ///< of them in one stratum
  double first = 0, second = 0;  ///< RMSE of each over the pairs, the mean over strata; nan without pairs
  Estimate difference;           ///< first minus second
  Interval narrow;               ///< with 1 - 2 (1 - confidence): two one-sided tests (Schuirmann 1987) use it
  Estimate improvement;          ///< probability that the first has the smaller error on a trial; ties count half
  double p = 0;                  ///< exchange test of the difference
  double adjusted_p = 0;         ///< after judge(); before it, equal to p
  Verdict verdict = Verdict::too_few;
};

/// Differences of RMSE, averaged over the strata with equal weight, each resampled within itself.
PairedComparison compare_pairs(const std::vector<std::vector<Pair>>& strata, const ResamplingOptions& options);

/// Adjusts the p of all comparisons as one family and gives the verdicts. A difference whose whole interval lies within
/// the rope is `equal` even if it is significant: it does not matter. `rope` is in the unit of the errors; 0: never
/// equal.
void judge(std::vector<PairedComparison>& family, double rope, double confidence);

/// "constrained beats registered by 0.14 mm (0.09–0.20)", "equal within 0.05 mm", ... `scale` turns the errors' unit
/// into the one that is printed.
std::string in_words(const PairedComparison& comparison, const std::string& first, const std::string& second,
                     double rope, double scale, const std::string& unit);

/// Median of the ratios first / second of paired times, with a percentile bootstrap interval, and the same for each
/// half of the pairs taken by turns: a difference counts as confirmed if all three intervals lie on one side of 1.
struct TimeComparison {
  std::size_t pairs = 0;
  Estimate ratio;
  Interval halves[2];
  bool confirmed = false;
};
TimeComparison compare_times(const std::vector<Pair>& seconds, const ResamplingOptions& options);

}  // namespace plumbline::statistics

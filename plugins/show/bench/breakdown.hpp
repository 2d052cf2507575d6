// Where alternatives break when a factor grows: noise, share of outliers, tags lost, a prior that is wrong.
#pragma once

#include "show/bench/bench_data.hpp"

namespace plumbline::bench {

/// Of one alternative over the values of one variable, everything else held. A site (a seed) holds at a value if its
/// trial has a result whose largest error is within the tolerance, and breaks at the first value at which it does not:
/// what it does behind is no merit. So every site has one place at which it breaks, and half of the sites need no curve
/// to be fitted: the median and its interval are order statistics, whatever the distribution.
struct Breakdown {
  std::string variable, place, name;  ///< place: scenario and the other variables, in words
  double tolerance = 0;               ///< [m]
  std::vector<std::string> values;    ///< of the variable, from where more sites hold to where fewer do
  std::vector<std::string> excluded;  ///< values of the variable that the bench leaves out here: nothing is open there
  bool by_worst = true;               ///< of largest errors; else of what the file measures as error
  std::size_t sites = 0;              ///< those of which every value up to their end has run
  std::size_t open = 0;               ///< further ones, of which the value that would tell has not run
  std::size_t median = 0;             ///< half of the sites hold at so many of the values, and not at the next
  std::size_t at_most = 0;            ///< the same if all that is open held; larger: the median is not known yet
  /// The same as an interval of the median; both ends `values.size() + 1` with too few sites for one.
  std::size_t lower = 0, upper = 0;
  bool has_interval() const { return upper <= values.size(); }
};

/// For each variable with three or more values that the bench runs there, all of them numbers; each place, alternative
/// and tolerance of the file. Without a largest error what was measured as error counts. `confidence` of the interval,
/// which is exact or wider.
std::vector<Breakdown> breakdowns(const Bench& bench, double confidence);

/// "up to 0.4 (0.3 to 0.5)", "not even at 0", "through 0.9".
std::string breakdown_text(const Breakdown& breakdown);

/// A sentence for each variable and place, at the first tolerance: who holds how far, the one that holds furthest
/// first.
std::vector<std::string> breakdown_sentences(const std::vector<Breakdown>& found);

}  // namespace plumbline::bench

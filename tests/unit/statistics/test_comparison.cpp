// Verdicts, their words, and the summary of one alternative.
#include <gmock/gmock.h>

#include <cmath>

#include "geometry/random.hpp"
#include "statistics/comparison.hpp"
#include "statistics/trial_summary.hpp"

namespace {

using namespace plumbline;
using namespace plumbline::statistics;
using testing::DoubleNear;
using testing::HasSubstr;

/// Errors of n trials; the second alternative's rms is `factor` times that of the first plus noise of its own.
std::vector<Pair> trials(size_t n, double factor, double own_noise, uint64_t seed) {
  Random random(seed);
  std::vector<Pair> list;
  for (size_t i = 0; i < n; ++i) {
    const double first = 1e-3 * (0.5 + 0.2 * random.uniform()),
                 second = factor * first + own_noise * random.normal() * 1e-3;
    list.push_back({first * first, second * second});
  }
  return list;
}

PairedComparison judged(const std::vector<std::vector<Pair>>& strata, double rope) {
  std::vector<PairedComparison> family{compare_pairs(strata, {})};
  judge(family, rope, 0.95);
  return family[0];
}

std::string words(const PairedComparison& c) { return in_words(c, "schur", "ceres", 5e-5, 1e3, "mm"); }

TEST(Verdict, OfAClearDifference) {
  const PairedComparison c = judged({trials(40, 1.3, 0.02, 1)}, 5e-5);
  EXPECT_EQ(c.verdict, Verdict::first_better);
  EXPECT_THAT(words(c), HasSubstr("schur beats ceres by 0.178 mm (0.169 to 0.186)"));
}

TEST(Verdict, NoWinnerWhereTheIntervalCoversZero) {
  const PairedComparison c = judged({trials(10, 1.0, 0.2, 2)}, 5e-5);
  ASSERT_LT(c.difference.interval.lower, 0);
  ASSERT_GT(c.difference.interval.upper, 0);
  EXPECT_EQ(c.verdict, Verdict::undecided);
  EXPECT_THAT(words(c), HasSubstr("no winner between schur and ceres"));
  EXPECT_THAT(words(c), HasSubstr("covers zero"));
}

TEST(Verdict, SignificantButBelowTheRopeIsEqual) {
  const PairedComparison c = judged({trials(100, 1.02, 0.001, 3)}, 5e-5);
  ASSERT_LT(c.difference.interval.upper, 0);  // 0.012 mm, and surely so
  EXPECT_EQ(c.verdict, Verdict::equal);
  EXPECT_THAT(words(c), HasSubstr("equal within 0.05 mm"));
  EXPECT_EQ(judged({trials(100, 1.02, 0.001, 3)}, 0).verdict, Verdict::first_better) << "without a rope it wins";
}

TEST(Verdict, IdenticalResultsAreEqual) {
  const PairedComparison c = judged({trials(10, 1.0, 0.0, 3)}, 5e-5);
  EXPECT_EQ(c.verdict, Verdict::equal);
  EXPECT_EQ(c.p, 1.0);
}

TEST(Verdict, FivePairsSayNothing) {
  const PairedComparison c = judged({trials(5, 3.0, 0.0, 1)}, 5e-5);
  EXPECT_EQ(c.verdict, Verdict::too_few);
  EXPECT_THAT(words(c), HasSubstr("5 trials that both finished, needed are 6"));
}

TEST(Verdict, APlaceWithASinglePairIsNamedAsTheCause) {
  const PairedComparison c = judged({trials(30, 3.0, 0.0, 1), trials(1, 3.0, 0.0, 2)}, 5e-5);
  EXPECT_EQ(c.verdict, Verdict::too_few);
  EXPECT_THAT(words(c), HasSubstr("of 31 trials that both finished, one place has only 1"));
}

TEST(Verdict, ADifferenceThatIsPrintedAsZeroHasNoSign) {
  PairedComparison c;
  c.verdict = Verdict::equal;
  c.pairs = 9;
  c.first = c.second = 1e-3;
  c.difference = {-1e-9, {-2e-9, 1e-9}};
  EXPECT_THAT(words(c), testing::Not(HasSubstr("-0.0")));
}

TEST(Verdict, HolmTakesTheWinOfALuckyComparisonAmongMany) {
  PairedComparison lucky;
  lucky.pairs = 20, lucky.p = 0.02;
  lucky.difference = {-1e-4, {-2e-4, -1e-5}}, lucky.narrow = {-1.8e-4, -2e-5};
  std::vector<PairedComparison> alone{lucky}, among{lucky};
  judge(alone, 0, 0.95);
  EXPECT_EQ(alone[0].verdict, Verdict::first_better);
  PairedComparison dull = lucky;
  dull.p = 0.5;
  among.insert(among.end(), 9, dull);
  judge(among, 0, 0.95);
  EXPECT_EQ(among[0].verdict, Verdict::undecided);
  EXPECT_DOUBLE_EQ(among[0].adjusted_p, 0.2);
}

TEST(ComparePairs, StrataCountAlikeWhateverTheirSize) {
  const auto small = trials(10, 2.0, 0, 1), large = trials(1000, 1.0, 0, 2);
  ResamplingOptions few;
  few.resamples = 50;
  const PairedComparison c = compare_pairs({small, large}, few);
  EXPECT_NEAR(c.difference.value, 0.5 * compare_pairs({small}, few).difference.value, 1e-12);
}

TEST(CompareTimes, MedianOfRatiosIgnoresAHiccup) {
  std::vector<Pair> seconds;
  for (int i = 0; i < 20; ++i) seconds.push_back({1.0 + 0.01 * (i % 3), 2.0 + 0.02 * (i % 5)});
  seconds[4].first = 100;  // the machine did something else
  const TimeComparison c = compare_times(seconds, {});
  EXPECT_THAT(c.ratio.value, DoubleNear(0.5, 0.02));
  EXPECT_TRUE(c.confirmed);
}

TEST(CompareTimes, ADifferenceInOneHalfOnlyIsNotConfirmed) {
  std::vector<Pair> seconds;
  for (int i = 0; i < 40; ++i) seconds.push_back({i % 2 ? 1.0 + 0.02 * (i % 7 - 3) : 0.5 + 0.01 * (i % 3), 1.0});
  EXPECT_FALSE(compare_times(seconds, {}).confirmed);
}

Trial trial(double rms, double worst) { return {rms, 0.2 * rms, worst, 1e-3, 0.9e-3, 4, 4}; }

TEST(TrialSummary, CountsTrialsWithoutResultAtEveryTolerance) {
  const TrialSummary s = summarise({trial(1e-3, 1.5e-3), trial(2e-3, 4e-3), trial(1e-3, 3e-3)}, 1, {2e-3, 5e-3}, {});
  EXPECT_EQ(s.trials, 4u);
  EXPECT_NEAR(s.rmse.value, std::sqrt(2.0) * 1e-3, 1e-12);
  EXPECT_NEAR(s.mean.value, 4e-3 / 3, 1e-12);
  EXPECT_NEAR(s.efficiency.value, 0.81 / 2, 1e-12);
  ASSERT_EQ(s.failure_rates.size(), 2u);
  EXPECT_EQ(s.failure_rates[0].failed, 3u);
  EXPECT_EQ(s.failure_rates[1].failed, 1u);
  // scipy.stats.binomtest(17, 200).proportion_ci(method="wilson")
  EXPECT_NEAR(wilson_interval(17, 200, 0.95).lower, 0.053745750177475606, 1e-12);
  EXPECT_NEAR(wilson_interval(17, 200, 0.95).upper, 0.13189587071565567, 1e-12);
}

TEST(TrialSummary, NeesBandIsThatOfChiSquared) {
  const TrialSummary s = summarise(std::vector<Trial>(60, trial(1e-3, 1e-3)), 0, {}, {});  // 240 degrees of freedom
  EXPECT_DOUBLE_EQ(s.nees, 1);
  EXPECT_NEAR(s.nees_band.lower, 0.82909938, 1e-7);  // scipy.stats.chi2.ppf
  EXPECT_NEAR(s.nees_band.upper, 1.18667702, 1e-7);
}

TEST(TrialSummary, WhatATrialDoesNotKnowIsNotAveraged) {
  std::vector<Trial> list(10, trial(1e-3, 1e-3));
  list[3].bound = std::nan("");
  const TrialSummary s = summarise(list, 0, {}, {});
  EXPECT_TRUE(std::isnan(s.efficiency.value));
  EXPECT_FALSE(std::isnan(s.rmse.value));
}

}  // namespace

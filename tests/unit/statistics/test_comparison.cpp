// Comparisons, verdicts and their words.
#include <gmock/gmock.h>

#include <cmath>

#include "base/statistics/comparison.hpp"
#include "geometry/random.hpp"

namespace test_comparison {

using namespace plumbline;
using namespace plumbline::statistics;
using testing::DoubleNear;
using testing::HasSubstr;

using Pairs = std::vector<std::pair<double, double>>;

/// Mean square errors of n trials; the second alternative's rms is `factor` times that of the first plus noise of its
/// own.
Pairs trials(size_t n, double factor, double own_noise, uint64_t seed) {
  Random random(seed);
  Pairs list;
  for (size_t i = 0; i < n; ++i) {
    const double first = 1e-3 * (0.5 + 0.2 * random.uniform()),
                 second = factor * first + own_noise * random.normal() * 1e-3;
    list.push_back({first * first, second * second});
  }
  return list;
}

/// Trial i of every place is that of seed i.
Place place(const Pairs& pairs, double weight = 1) {
  Place result{weight, {}};
  for (const auto& [first, second] : pairs)
    result.encounters.push_back({result.encounters.size(), first, second, 0, 0});
  return result;
}

/// Adds seeds that only one of them finished.
Place with_failures(Place given, size_t only_first, size_t only_second) {
  for (size_t i = 0; i < only_first + only_second; ++i)
    given.encounters.push_back(
        {given.encounters.size(), std::nan(""), std::nan(""), i < only_first ? 1.0 : 0.0, i < only_first ? 0.0 : 1.0});
  return given;
}

PairedComparison judged(const std::vector<Place>& places, double rope) {
  std::vector<PairedComparison> family{compare(places, {})};
  judge(family, rope, 0.95);
  return family[0];
}

std::string words(const PairedComparison& c) { return in_words(c, "schur", "ceres", 5e-5, 1e3, "mm"); }

TEST(Verdict, OfAClearDifference) {
  const PairedComparison c = judged({place(trials(40, 1.3, 0.02, 1))}, 5e-5);
  EXPECT_EQ(c.verdict, Verdict::first_better);
  EXPECT_THAT(words(c), HasSubstr("schur beats ceres by 0.178 mm (0.169 to 0.186)"));
}

TEST(Verdict, NoWinnerWhereTheIntervalCoversZero) {
  const PairedComparison c = judged({place(trials(10, 1.0, 0.2, 2))}, 5e-5);
  ASSERT_LT(c.difference.interval.lower, 0);
  ASSERT_GT(c.difference.interval.upper, 0);
  EXPECT_EQ(c.verdict, Verdict::undecided);
  EXPECT_THAT(words(c), HasSubstr("no winner between schur and ceres"));
  EXPECT_THAT(words(c), HasSubstr("covers zero"));
}

TEST(Verdict, SignificantButBelowTheRopeIsEqual) {
  const PairedComparison c = judged({place(trials(100, 1.02, 0.001, 3))}, 5e-5);
  ASSERT_LT(c.difference.interval.upper, 0);  // 0.012 mm, and surely so
  EXPECT_EQ(c.verdict, Verdict::equal);
  EXPECT_THAT(words(c), HasSubstr("equal within 0.05 mm"));
  EXPECT_EQ(judged({place(trials(100, 1.02, 0.001, 3))}, 0).verdict, Verdict::first_better) << "without a rope it wins";
}

TEST(Verdict, IdenticalResultsAreEqual) {
  const PairedComparison c = judged({place(trials(10, 1.0, 0.0, 3))}, 5e-5);
  EXPECT_EQ(c.verdict, Verdict::equal);
  EXPECT_EQ(c.p, 1.0);
}

TEST(Verdict, FivePairsSayNothing) {
  const PairedComparison c = judged({place(trials(5, 3.0, 0.0, 1))}, 5e-5);
  EXPECT_EQ(c.verdict, Verdict::too_few);
  EXPECT_THAT(words(c), HasSubstr("5 trials that both finished, needed are 6"));
}

/// Once a place in which 3 of 200 had finished had the weight of one with 200, and made a headline of 0.15 mm.
TEST(Verdict, APlaceWithFewerThanSixPairsCountsInNoSummary) {
  const PairedComparison c = judged({place(trials(30, 1.3, 0.02, 1)), place(trials(5, 9.0, 0.0, 2))}, 5e-5);
  EXPECT_EQ(c.places, 1u);
  EXPECT_EQ(c.left_out, 1u);
  EXPECT_DOUBLE_EQ(c.difference.value, judged({place(trials(30, 1.3, 0.02, 1))}, 5e-5).difference.value);
}

TEST(Verdict, WhatFailsWhereTheOtherFinishesLoses) {
  const PairedComparison c = judged({with_failures(place(trials(3, 1.0, 0.1, 1)), 197, 0)}, 5e-5);
  EXPECT_EQ(c.verdict, Verdict::first_better);
  EXPECT_GT(c.improvement.value, 0.98);
  EXPECT_EQ(words(c),
            "schur beats ceres: it gives a result in 197 trials in which ceres gives none; of the errors nothing can "
            "be said, 3 trials that both finished");
}

TEST(Verdict, SmallerErrorsWithFewerResultsAreNoWin) {
  const PairedComparison c = judged({with_failures(place(trials(40, 1.3, 0.02, 1)), 0, 20)}, 5e-5);
  EXPECT_EQ(c.verdict, Verdict::opposed);
  EXPECT_THAT(words(c), HasSubstr("schur beats ceres by 0.178 mm"));
  EXPECT_THAT(words(c), HasSubstr("but ceres gives a result in 20 trials in which schur gives none: no winner"));
}

TEST(Verdict, AFewFailuresAreToldBesideIt) {
  const PairedComparison c = judged({with_failures(place(trials(40, 1.3, 0.02, 1)), 1, 2)}, 5e-5);
  EXPECT_EQ(c.verdict, Verdict::first_better);
  EXPECT_THAT(words(c), HasSubstr("besides them 1 only by schur, 2 only by ceres"));
}

TEST(Verdict, TheSameResultsAreSaidToBeTheSame) {
  EXPECT_THAT(words(judged({place(trials(10, 1.0, 0.0, 3))}, 5e-5)),
              HasSubstr("schur and ceres gave the same in all 10 trials"));
  EXPECT_THAT(words(judged({place(trials(10, 1.0, 0.0, 3))}, 0)), HasSubstr("gave the same in all 10 trials"));
}

TEST(Verdict, WhatIsUndecidedSaysHowManySeedsWouldShowIt) {
  const PairedComparison c = judged({place(trials(10, 1.0, 0.2, 2))}, 5e-5);
  EXPECT_THAT(words(c), testing::ContainsRegex("; [0-9]+ seeds would show 0.05 mm"));
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

TEST(Verdict, WhatGaveTheSameTakesNoErrorProbabilityFromTheOthers) {
  PairedComparison lucky, same;
  lucky.pairs = 20, lucky.p = 0.02, lucky.places = 1;
  lucky.difference = {-1e-4, {-2e-4, -1e-5}}, lucky.narrow = {-1.8e-4, -2e-5};
  same.p = 1, same.same = true;
  std::vector<PairedComparison> family(10, same);
  family.push_back(lucky);
  judge(family, 0, 0.95);
  EXPECT_EQ(family.back().verdict, Verdict::first_better);
}

// The trials of scipy.stats below.
const std::vector<double> x{0.31, 0.22, 0.55, 0.19, 0.87, 0.41, 0.29, 0.36, 0.62, 0.25,
                            0.33, 1.42, 0.28, 0.47, 0.39, 0.21, 0.58, 0.44, 0.30, 0.76};
const std::vector<double> y{0.42, 0.25, 0.51, 0.33, 1.01, 0.40, 0.45, 0.39, 0.80, 0.31,
                            0.30, 1.55, 0.41, 0.52, 0.38, 0.35, 0.66, 0.49, 0.47, 0.73};

Pairs pairs(size_t count) {
  Pairs list;
  for (size_t i = 0; i < count; ++i) list.push_back({x[i] * x[i], y[i] * y[i]});
  return list;
}

TEST(Compare, TestOfTheDifferenceOfRmseIsSciPys) {
  const PairedComparison c = compare({place(pairs(20))}, {0.95, 40000, 3});
  EXPECT_NEAR(c.difference.value, -0.0700764875, 1e-9);
  EXPECT_NEAR(c.p, 0.00076, 0.0005);          // scipy.stats.permutation_test, samples exchanged in pairs
  EXPECT_EQ(c.improvement.value, 15.0 / 20);  // counted by hand
  EXPECT_DOUBLE_EQ(compare({place(pairs(10))}, {}).p, 0.025390625);  // 26 of 1024
}

TEST(Compare, ExchangingTheAlternativesExchangesTheAnswer) {
  Pairs swapped;
  for (const auto& [first, second] : pairs(20)) swapped.push_back({second, first});
  const PairedComparison a = compare({place(pairs(20))}, {}), b = compare({place(swapped)}, {});
  EXPECT_EQ(a.difference.value, -b.difference.value);
  EXPECT_NEAR(a.difference.interval.lower, -b.difference.interval.upper, 1e-12);
  EXPECT_EQ(a.p, b.p);
  EXPECT_NEAR(a.improvement.value, 1 - b.improvement.value, 1e-12);
}

/// A second place that repeats the first says nothing new. Drawn for itself it made the interval 1.41 times narrower.
TEST(Compare, APlaceThatRepeatsAnotherAddsNothing) {
  const Place once = place(trials(30, 1.1, 0.2, 4));
  const PairedComparison one = compare({once}, {}), four = compare({once, once, once, once}, {});
  EXPECT_NEAR(four.difference.interval.lower, one.difference.interval.lower, 1e-12);
  EXPECT_NEAR(four.difference.interval.upper, one.difference.interval.upper, 1e-12);
  EXPECT_EQ(four.p, one.p);
  EXPECT_EQ(four.seeds, 30u);
  ASSERT_TRUE(four.spread);
  EXPECT_EQ(four.spread->deviation, 0);
}

TEST(Compare, PlacesCountByTheWeightThatIsStated) {
  const Pairs differ = trials(10, 2.0, 0, 1), agree = trials(60, 1.0, 0, 2);
  const double alone = compare({place(differ)}, {}).difference.value;
  EXPECT_NEAR(compare({place(differ), place(agree)}, {}).difference.value, 0.5 * alone, 1e-12);
  EXPECT_NEAR(compare({place(differ, 3), place(agree, 1)}, {}).difference.value, 0.75 * alone, 1e-12);
}

/// Once the places that lacked pairs kept their share of a scenario's weight, so that 1 : 1 was 1 : 3 and the other
/// won.
TEST(Compare, PlacesThatCountShareTheWeightOfTheirStratum) {
  const auto of = [](Place place, const std::string& stratum) {
    place.stratum = stratum;
    return place;
  };
  const Pairs worse = trials(10, 0.5, 0, 1), better = trials(10, 2.0, 0, 2), few = trials(3, 0.5, 0, 3);
  const double one = compare({place(worse)}, {}).difference.value, two = compare({place(better)}, {}).difference.value;
  const PairedComparison c = compare({of(place(worse), "one"), of(place(few), "one"), of(place(few), "one"),
                                      of(place(better), "two"), of(place(better), "two"), of(place(better, 1), "two")},
                                     {});
  EXPECT_NEAR(c.difference.value, 0.5 * (one + two), 1e-12);
  EXPECT_TRUE(c.silent.empty());
  const PairedComparison uneven = compare({of(place(worse, 3), "one"), of(place(better, 1), "two")}, {});
  EXPECT_NEAR(uneven.difference.value, 0.75 * one + 0.25 * two, 1e-12);
}

/// Whose weight has nowhere to go is not spread over the others.
TEST(Compare, AStratumWithoutPlacesIsNoMean) {
  Place one = place(trials(40, 1.3, 0.02, 1)), none;
  one.stratum = "one", none.stratum = "two";
  const PairedComparison c = judged({one, none}, 5e-5);
  EXPECT_EQ(c.verdict, Verdict::too_few);
  EXPECT_TRUE(std::isnan(c.difference.value));
  EXPECT_THAT(words(c),
              HasSubstr("nothing can be said of schur and ceres: two has no place with 6 trials that both finished"));
}

TEST(Compare, WeightsOfAnySizeAreRatios) {
  const Place a = place(trials(10, 2.0, 0, 1), 3e300), b = place(trials(60, 1.0, 0, 2), 1e300);
  const PairedComparison large = compare({a, b}, {});
  const PairedComparison small = compare({place(trials(10, 2.0, 0, 1), 3), place(trials(60, 1.0, 0, 2), 1)}, {});
  EXPECT_NEAR(large.difference.value, small.difference.value, 1e-12);
  EXPECT_NEAR(large.difference.interval.lower, small.difference.interval.lower, 1e-9);
}

TEST(Compare, SpreadIsWhatGoesBeyondTheNoise) {
  // Places that differ by noise alone, and places of which every second has another difference.
  std::vector<Place> alike, unlike;
  for (uint64_t k = 0; k < 8; ++k) {
    alike.push_back(place(trials(50, 1.0, 0.1, k)));
    unlike.push_back(place(trials(50, k % 2 ? 1.5 : 1.0, 0.1, k)));
  }
  EXPECT_LT(compare(alike, {}).spread->deviation, 2e-5);
  const Spread found = *compare(unlike, {}).spread;
  EXPECT_NEAR(found.deviation, 0.5 * 0.3e-3 * std::sqrt(8.0 / 7), 2e-5);  // half of 0.5 times 0.6 mm, either way
  EXPECT_NEAR(found.lowest, -0.3e-3, 5e-5);
}

TEST(CompareTimes, MedianOfRatiosIgnoresAHiccup) {
  std::vector<TimePair> seconds;
  for (uint64_t i = 0; i < 20; ++i)
    seconds.push_back({i, 1.0 + 0.01 * static_cast<double>(i % 3), 2.0 + 0.02 * static_cast<double>(i % 5)});
  seconds[4].first = 100;  // the machine did something else
  const TimeComparison c = compare_times(seconds, {});
  EXPECT_THAT(c.ratio.value, DoubleNear(0.5, 0.02));
  EXPECT_TRUE(c.confirmed);
}

TEST(CompareTimes, ADifferenceInOneHalfOnlyIsNotConfirmed) {
  std::vector<TimePair> seconds;
  for (int i = 0; i < 40; ++i)
    seconds.push_back({static_cast<uint64_t>(i), i % 2 ? 1.0 + 0.02 * (i % 7 - 3) : 0.5 + 0.01 * (i % 3), 1.0});
  EXPECT_FALSE(compare_times(seconds, {}).confirmed);
}

}  // namespace test_comparison

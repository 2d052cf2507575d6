// Intervals and tests by seed: against SciPy 1.10.1 (permutation_test, binomtest), closed formulas and counting by
// hand.
#include <gmock/gmock.h>

#include <cmath>
#include <numeric>

#include "base/statistics/by_seed.hpp"

namespace test_by_seed {

using namespace plumbline;
using namespace plumbline::statistics;
using testing::DoubleNear;
using testing::ElementsAre;

const std::vector<double> x{0.31, 0.22, 0.55, 0.19, 0.87, 0.41, 0.29, 0.36, 0.62, 0.25,
                            0.33, 1.42, 0.28, 0.47, 0.39, 0.21, 0.58, 0.44, 0.30, 0.76};

double weighted_mean(const Weights& w) {
  double sum = 0, total = 0;
  for (size_t i = 0; i < w.size(); ++i) sum += w[i] * x[i], total += w[i];
  return sum / total;
}

/// Of a mean it is what every textbook has: s / √n and Student's t.
TEST(Jackknife, OfAMeanIsTheTextbooksInterval) {
  const Jackknife found = jackknife(x.size(), weighted_mean);
  const double mean = std::accumulate(x.begin(), x.end(), 0.0) / 20;
  double squares = 0;
  for (const double value : x) squares += (value - mean) * (value - mean);
  EXPECT_NEAR(found.standard_error, std::sqrt(squares / 19 / 20), 1e-14);
  EXPECT_NEAR(found.deviation(), std::sqrt(squares / 19), 1e-13);
  const Interval interval = found.interval(0.95);
  EXPECT_NEAR(interval.upper - mean, 2.093024054408263 * found.standard_error, 1e-9);  // t of 19, from tables
  EXPECT_NEAR(mean - interval.lower, interval.upper - mean, 1e-14);
}

TEST(Jackknife, OfARootMeanSquareStaysAboveZero) {
  const Estimate e = estimate(
      3, [](const Weights& w) { return std::sqrt((w[0] * 100 + w[1] + w[2]) / (w[0] + w[1] + w[2])); }, 0.95,
      Scale::logarithmic);
  EXPECT_GT(e.interval.lower, 0);
  EXPECT_NEAR(e.interval.upper / e.value, e.value / e.interval.lower, 1e-9);
}

TEST(Jackknife, WithoutVariationHasNoWidthAndWithOneSeedNoInterval) {
  const auto constant = [](const Weights&) { return 2.5; };
  EXPECT_EQ(estimate(5, constant, 0.95, Scale::plain).interval.lower, 2.5);
  EXPECT_EQ(estimate(5, constant, 0.95, Scale::logarithmic).interval.upper, 2.5);
  EXPECT_TRUE(std::isnan(estimate(1, constant, 0.95, Scale::plain).interval.lower));
}

TEST(ExchangeTest, OneThatIsDrawnIsNeverImpossible) {
  // 40 seeds that all differ alike: as extreme is only no exchange or all of them, which is not drawn in 2000 rounds.
  const auto sum = [](const Weights& signs) { return std::accumulate(signs.begin(), signs.end(), 0.0); };
  EXPECT_DOUBLE_EQ(exchange_test(40, sum, {0.95, 2000, 1}), 1.0 / 2001);
}

TEST(ExchangeTest, SixSeedsThatAgreeAreJustSignificant) {
  const auto sum = [](const Weights& signs) { return std::accumulate(signs.begin(), signs.end(), 0.0); };
  EXPECT_DOUBLE_EQ(exchange_test(6, sum, {}), 2.0 / 64);
  EXPECT_DOUBLE_EQ(exchange_test(5, sum, {}), 2.0 / 32) << "so least_seeds is 6";
}

TEST(ExchangeTest, ManyComparisonsNeedMoreSeeds) {
  EXPECT_EQ(seeds_for_risk(0.05), 6u);
  EXPECT_EQ(seeds_for_risk(0.05 / 40), 11u) << "2 / 2048";
}

TEST(ExchangeTest, OneThatIsNotSignificantIsGivenUpEarly) {
  size_t asked = 0;
  const auto mixed = [&](const Weights& signs) {
    ++asked;
    double sum = 0;
    for (size_t i = 0; i < signs.size(); ++i) sum += signs[i] * (i % 2 ? 1.0 : -1.05);
    return sum;
  };
  const double p = exchange_test(40, mixed, {0.95, 1'000'000, 1});
  EXPECT_GT(p, 0.5);
  EXPECT_LT(asked, 2000u);
}

TEST(Holm, StepsDownAndKeepsTheOrder) {
  // By hand: sorted 0.01 0.02 0.03 0.04 times 4 3 2 1 = 0.04 0.06 0.06 0.04, made monotonous.
  EXPECT_THAT(holm({0.04, 0.01, 0.03, 0.02}), ElementsAre(0.06, 0.04, 0.06, 0.06));
  EXPECT_THAT(holm({0.6, 0.7}), ElementsAre(1.0, 1.0));
}

TEST(Holm, ATestWithHalfOfTheErrorProbabilityPaysForTwo) {
  // Shares 2, 1, 1: p / share sorted 0.005, 0.03, 0.04; times the shares left 4, 2, 1 = 0.02, 0.06, 0.06.
  const std::vector<double> adjusted = holm({0.01, 0.03, 0.04}, {2, 1, 1});
  EXPECT_THAT(adjusted, ElementsAre(DoubleNear(0.02, 1e-15), DoubleNear(0.06, 1e-15), DoubleNear(0.06, 1e-15)));
}

TEST(SeedsToShow, AreThoseOfThePairedTTest) {
  // Tables of the paired t test (Cohen 1988, two-sided 0.05, power 0.8): 34 pairs for d = 0.5, 199 for d = 0.2.
  EXPECT_NEAR(seeds_to_show(0.5, 1, 0.05, 0.8), 34, 1);
  EXPECT_NEAR(seeds_to_show(0.2, 1, 0.05, 0.8), 199, 1);
  EXPECT_EQ(seeds_to_show(100, 1, 0.05, 0.8), 6);
  EXPECT_TRUE(std::isnan(seeds_to_show(0, 1, 0.05, 0.8)));
}

TEST(Quantile, LiesBetweenTheOrderStatistics) {
  EXPECT_DOUBLE_EQ(quantile({1, 2, 4}, 0.75), 3);
  EXPECT_DOUBLE_EQ(quantile({1, 2, 4}, 1), 4);
}

TEST(WilsonInterval, IsSciPys) {
  // scipy.stats.binomtest(17, 200).proportion_ci(method="wilson")
  EXPECT_NEAR(wilson_interval(17, 200, 0.95).lower, 0.053745750177475606, 1e-12);
  EXPECT_NEAR(wilson_interval(17, 200, 0.95).upper, 0.13189587071565567, 1e-12);
}

}  // namespace test_by_seed

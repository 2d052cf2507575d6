// Intervals and tests against SciPy 1.10.1 (scipy.stats.bootstrap with method BCa and 200 000 resamples,
// permutation_test, binomtest), which is not our code.
#include <gmock/gmock.h>

#include <cmath>
#include <numeric>

#include "geometry/random.hpp"
#include "statistics/comparison.hpp"
#include "statistics/resampling.hpp"

namespace {

using namespace plumbline;
using namespace plumbline::statistics;
using testing::DoubleNear;
using testing::ElementsAre;

const std::vector<double> x{0.31, 0.22, 0.55, 0.19, 0.87, 0.41, 0.29, 0.36, 0.62, 0.25,
                            0.33, 1.42, 0.28, 0.47, 0.39, 0.21, 0.58, 0.44, 0.30, 0.76};
const std::vector<double> y{0.42, 0.25, 0.51, 0.33, 1.01, 0.40, 0.45, 0.39, 0.80, 0.31,
                            0.30, 1.55, 0.41, 0.52, 0.38, 0.35, 0.66, 0.49, 0.47, 0.73};

double rms(const std::vector<double>& values, const std::vector<double>& weights) {
  double sum = 0, total = 0;
  for (size_t i = 0; i < values.size(); ++i) sum += weights[i] * values[i] * values[i], total += weights[i];
  return std::sqrt(sum / total);
}

std::vector<Pair> pairs(size_t count) {
  std::vector<Pair> list;
  for (size_t i = 0; i < count; ++i) list.push_back({x[i] * x[i], y[i] * y[i]});
  return list;
}

const ResamplingOptions many{0.95, 40000, 3};

TEST(Bca, OfASkewedStatisticIsSciPys) {
  const auto intervals = bca_intervals(
      {x.size()}, [](const Weights& w) { return rms(x, w[0]); }, {0.90, 0.95, 0.99}, many);
  EXPECT_THAT(intervals[0].lower, DoubleNear(0.4291, 0.003));
  EXPECT_THAT(intervals[0].upper, DoubleNear(0.7552, 0.006));
  EXPECT_THAT(intervals[1].lower, DoubleNear(0.4142, 0.003));
  EXPECT_THAT(intervals[1].upper, DoubleNear(0.8059, 0.006));
  EXPECT_THAT(intervals[2].lower, DoubleNear(0.3904, 0.004));
  EXPECT_THAT(intervals[2].upper, DoubleNear(0.9131, 0.012));
}

TEST(Bca, OfTwoStrataIsSciPys) {
  const std::vector<double> u(x.begin(), x.begin() + 12), v(y.begin() + 8, y.end());
  const Estimate mean = bca(
      {u.size(), v.size()}, [&](const Weights& w) { return 0.5 * (rms(u, w[0]) + rms(v, w[1])); }, many);
  EXPECT_THAT(mean.value, DoubleNear(0.62986734, 1e-8));
  EXPECT_THAT(mean.interval.lower, DoubleNear(0.4899, 0.004));
  EXPECT_THAT(mean.interval.upper, DoubleNear(0.8811, 0.008));
}

TEST(Bca, WithoutVariationHasNoWidthAndWithOneTrialNoInterval) {
  const auto mean = [](const Weights& w) { return w[0][0] > 0 || w[0][1] > 0 ? 2.5 : 2.5; };
  EXPECT_EQ(bca({5}, mean, many).interval.lower, 2.5);
  EXPECT_EQ(bca({5}, mean, many).interval.upper, 2.5);
  EXPECT_TRUE(std::isnan(bca(
                             {1}, [](const Weights&) { return 1.0; }, many)
                             .interval.lower));
}

TEST(ComparePairs, DifferenceOfRmseIsSciPys) {
  const PairedComparison c = compare_pairs({pairs(20)}, many);
  EXPECT_THAT(c.difference.value, DoubleNear(-0.0700764875, 1e-9));
  EXPECT_THAT(c.difference.interval.lower, DoubleNear(-0.0964, 0.0015));
  EXPECT_THAT(c.difference.interval.upper, DoubleNear(-0.0376, 0.0015));
  EXPECT_THAT(c.narrow.lower, DoubleNear(-0.0922, 0.0015));
  EXPECT_THAT(c.narrow.upper, DoubleNear(-0.0430, 0.0015));
  EXPECT_THAT(c.p, DoubleNear(0.00076, 0.0005));
  EXPECT_EQ(c.improvement.value, 15.0 / 20);  // counted by hand
}

TEST(ComparePairs, FewPairsAreExchangedInAllWays) {
  EXPECT_DOUBLE_EQ(compare_pairs({pairs(10)}, many).p, 0.025390625);  // 26 of 1024
}

TEST(ComparePairs, ExchangingTheAlternativesExchangesTheAnswer) {
  std::vector<Pair> swapped;
  for (const Pair& pair : pairs(20)) swapped.push_back({pair.second, pair.first});
  const PairedComparison a = compare_pairs({pairs(20)}, many), b = compare_pairs({swapped}, many);
  EXPECT_EQ(a.difference.value, -b.difference.value);
  EXPECT_NEAR(a.difference.interval.lower, -b.difference.interval.upper, 1e-12);
  EXPECT_EQ(a.p, b.p);
  EXPECT_NEAR(a.improvement.value, 1 - b.improvement.value, 1e-12);
}

TEST(ComparePairs, AnExchangeThatIsDrawnIsNeverImpossible) {
  // 40 pairs that all differ alike: as extreme is only no exchange or all of them, which is not drawn in 2000 rounds.
  const auto sum = [](const Weights& signs) { return std::accumulate(signs[0].begin(), signs[0].end(), 0.0); };
  EXPECT_DOUBLE_EQ(exchange_test({40}, sum, {}), 1.0 / 2001);
}

TEST(Holm, StepsDownAndKeepsTheOrder) {
  // By hand: sorted 0.01 0.02 0.03 0.04 times 4 3 2 1 = 0.04 0.06 0.06 0.04, made monotonous.
  EXPECT_THAT(holm({0.04, 0.01, 0.03, 0.02}), ElementsAre(0.06, 0.04, 0.06, 0.06));
  EXPECT_THAT(holm({0.6, 0.7}), ElementsAre(1.0, 1.0));
}

TEST(Bca, CoversTheTruthAsOftenAsItSays) {
  // Means of 30 exponential variates: skewed, so that a symmetric interval would do worse. 600 samples: ± 1.8 % is two
  // sigma; BCa is known to fall a little short at this size.
  int covered = 0;
  for (uint64_t k = 0; k < 600; ++k) {
    Random random(k, "coverage");
    std::vector<double> sample;
    for (int i = 0; i < 30; ++i) sample.push_back(-std::log(1 - random.uniform()));
    const Estimate mean = bca({sample.size()},
                              [&](const Weights& w) {
                                double sum = 0;
                                for (size_t i = 0; i < sample.size(); ++i) sum += w[0][i] * sample[i];
                                return sum / 30;
                              },
                              {0.95, 500, k + 1});
    covered += mean.interval.lower <= 1 && 1 <= mean.interval.upper;
  }
  EXPECT_GT(covered, 600 * 0.90);
  EXPECT_LT(covered, 600 * 0.975);
}

}  // namespace

// The coin: two alternatives that may be exchanged, at 1 to 16 places that share their seeds. A bench of it names a
// winner in one of twenty at most, and its intervals hold what they say. PLUMBLINE_LONG makes it a thousand benches
// a row.
#include <gmock/gmock.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "base/statistics/comparison.hpp"
#include "geometry/random.hpp"

namespace test_coverage {

using namespace plumbline;
using namespace plumbline::statistics;

struct Coin {
  size_t places = 1, seeds = 30;
  double correlation = 0;  ///< of errors of one alternative between places
  double failures = 0;     ///< share of cells without result
  bool ties = false;       ///< errors in steps
  double second = 1;       ///< error of the second, in units of the first
};

double error_of(const Coin& coin, Random& random, double site) {
  const double z = std::sqrt(coin.correlation) * site + std::sqrt(1 - coin.correlation) * random.normal();
  const double error = 1 + 0.2 * z;
  return coin.ties ? std::round(5 * error) / 5 : error;
}

std::vector<Place> bench_of(const Coin& coin, uint64_t number) {
  Random random(number, "coin");
  std::vector<Place> places(coin.places);
  for (uint64_t seed = 1; seed <= coin.seeds; ++seed) {
    const double first_site = random.normal(), second_site = random.normal();
    for (Place& place : places) {
      const double a = error_of(coin, random, first_site), b = coin.second * error_of(coin, random, second_site);
      const bool first = random.uniform() >= coin.failures, second = random.uniform() >= coin.failures;
      const bool both = first && second;
      place.encounters.push_back({seed, both ? a * a : std::nan(""), both ? b * b : std::nan(""),
                                  first && !second ? 1.0 : 0.0, second && !first ? 1.0 : 0.0});
    }
  }
  return places;
}

/// As `plumbline bench` with stated weights judges: half of the error probability for all places together.
std::vector<PairedComparison> judged(const std::vector<Place>& places, double rope, double confidence = 0.95) {
  const InferenceOptions options{confidence, 999, 1};
  std::vector<PairedComparison> family;
  std::vector<double> shares;
  for (const Place& place : places) {
    family.push_back(compare({place}, options));
    shares.push_back(1.0 / static_cast<double>(places.size()));
  }
  if (places.size() > 1) {
    family.push_back(compare(places, options));
    shares.push_back(1);
  }
  judge(family, rope, confidence, shares);
  return family;
}

bool names_a_winner(const std::vector<PairedComparison>& family) {
  for (const PairedComparison& c : family)
    if (c.verdict == Verdict::first_better || c.verdict == Verdict::second_better || c.verdict == Verdict::opposed)
      return true;
  return false;
}

int benches(int few) { return std::getenv("PLUMBLINE_LONG") ? 1000 : few; }

/// The most that a share of 5 % of `n` gives but once in a thousand.
double limit_of(int n) { return 0.05 * n + 3.1 * std::sqrt(0.05 * 0.95 * n); }

TEST(Coin, OfExchangeableAlternativesNoneWins) {
  int all = 0, all_winners = 0;
  for (const size_t places : {1, 2, 6, 16})
    for (const double correlation : {0.0, 0.5, 0.9})
      for (const bool rough : {false, true}) {
        const int count = benches(30);
        int winners = 0;
        for (int k = 0; k < count; ++k) {
          const Coin coin{places, 30, correlation, rough ? 0.2 : 0, rough};
          winners += names_a_winner(judged(bench_of(coin, static_cast<uint64_t>(k)), 0.001));
        }
        EXPECT_LE(winners, limit_of(count)) << places << " places, correlation " << correlation << ", rough " << rough;
        all += count, all_winners += winners;
      }
  EXPECT_LE(all_winners, limit_of(all));
  std::printf("%d of %d benches name a winner\n", all_winners, all);
}

/// Whether a bench that looks after 10, 20 and 30 seeds names a winner at one of them.
bool wins_at_a_look(const Coin& coin, uint64_t number, double confidence) {
  const std::vector<Place> whole = bench_of(coin, number);
  for (const size_t look : {10, 20, 30}) {
    std::vector<Place> places = whole;
    for (Place& place : places) place.encounters.resize(look);
    if (names_a_winner(judged(places, 0.001, confidence))) return true;
  }
  return false;
}

/// Stopping at the first winner, each look has its share. With 95 % at each look more of the same benches name one.
TEST(Coin, WithLooksNoneWinsMoreOften) {
  int all = 0, winners = 0, without_shares = 0;
  for (const size_t places : {1, 6})
    for (const double correlation : {0.0, 0.9})
      for (const double failures : {0.0, 0.1, 0.4}) {
        const int count = benches(places == 1 ? 60 : 20);
        const Coin coin{places, 30, correlation, failures, failures > 0.3};
        for (int k = 0; k < count; ++k) {
          const auto number = static_cast<uint64_t>(k) + 5000;
          winners += wins_at_a_look(coin, number, confidence_of_a_look(3));
          without_shares += wins_at_a_look(coin, number, 0.95);
        }
        all += count;
      }
  EXPECT_LE(winners, limit_of(all));
  EXPECT_GT(without_shares, 2 * winners) << "or looking three times costs nothing";
  std::printf("%d of %d benches with three looks name a winner, %d without shares\n", winners, all, without_shares);
}

/// With the site's noise in common, the interval over all places is as wide as that of whole seeds.
TEST(Coin, IntervalsHoldWhatTheySay) {
  int all = 0, all_held = 0;
  for (const size_t seeds : {10, 30})
    for (const size_t places : {1, 6, 16})
      for (const double correlation : {0.0, 0.7, 0.9})
        for (const double second : {1.0, 1.3}) {
          const int count = benches(60);
          int held = 0;
          const double truth = std::sqrt(1.04) * (1 - second);
          for (int k = 0; k < count; ++k) {
            const Coin coin{places, seeds, correlation, seeds > 10 ? 0.15 : 0, false, second};
            const auto c = compare(bench_of(coin, static_cast<uint64_t>(k) + 1000), {0.95, 1, 1});
            held += c.difference.interval.lower <= truth && truth <= c.difference.interval.upper;
          }
          EXPECT_NEAR(held, 0.95 * count, 0.02 * count + 3.1 * std::sqrt(0.0475 * count))
              << seeds << " seeds, " << places << " places, correlation " << correlation << ", second " << second;
          all += count, all_held += held;
        }
  EXPECT_GE(all_held, 0.93 * all);
  EXPECT_LE(all_held, 0.97 * all);
  std::printf("%d of %d intervals hold the difference\n", all_held, all);
}

/// Places with other seeds: 6 pairs here and 60 there have the freedom of the 6.
TEST(Coin, IntervalsHoldWherePlacesHaveFewPairs) {
  const int count = benches(300);
  int held = 0;
  for (int k = 0; k < count; ++k) {
    std::vector<Place> places = bench_of({2, 60, 0.7}, static_cast<uint64_t>(k) + 5000);
    for (size_t i = 6; i < 60; ++i) {
      Encounter& e = places[1].encounters[i];
      e.first = e.second = std::nan("");
    }
    const auto c = compare(places, {0.95, 1, 1});
    held += c.difference.interval.lower <= 0 && 0 <= c.difference.interval.upper;
  }
  EXPECT_GE(held, 0.93 * count - 2 * std::sqrt(0.0475 * count));
}

/// "So many seeds would show it" is true in four of five benches.
TEST(Coin, AsManySeedsAsStatedShowTheDifference) {
  const Coin small{6, 20, 0.7};
  const PairedComparison c = judged(bench_of(small, 7), 0.05).back();
  ASSERT_EQ(c.verdict, Verdict::undecided);
  const double difference = 0.05 / std::sqrt(1.04);
  // The deviation is estimated from 20 seeds, so the mean over benches of what it asks for.
  double seeds = 0;
  for (uint64_t k = 0; k < 40; ++k) {
    const PairedComparison one = judged(bench_of(small, k), 0.05).back();
    seeds += seeds_to_show(0.05, one.deviation, 0.025, 0.8) / 40;
  }
  const int count = benches(100);
  int shown = 0;
  for (int k = 0; k < count; ++k) {
    Coin enough = small;
    enough.seeds = static_cast<size_t>(seeds);
    enough.second = 1 + difference;
    const auto family = judged(bench_of(enough, static_cast<uint64_t>(k) + 300), 0);
    shown += family.back().verdict == Verdict::first_better;
  }
  EXPECT_GE(shown, 0.8 * count - 3.1 * std::sqrt(0.16 * count) - 0.03 * count);
  EXPECT_LE(shown, 0.95 * count);
  std::printf("%d of %d benches with %.0f seeds show it\n", shown, count, seeds);
}

}  // namespace test_coverage

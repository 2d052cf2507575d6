// Where an alternative breaks: the median over sites of the value at which each of them breaks.
#include <gmock/gmock.h>

#include <cmath>

#include "show/bench/breakdown.hpp"

namespace plumbline::bench {
namespace test_breakdown {

using testing::ElementsAre;
using testing::HasSubstr;

/// `breaks_at` by seed: the number of the first of six values at which that site's error is too large.
Bench bench_of(const std::vector<std::size_t>& breaks_at, bool fewer_is_worse = false) {
  Bench bench;
  bench.tolerances = {0.002, 0.005};
  bench.variables = {{"outliers", {"0", "0.1", "0.2", "0.3", "0.4", "0.5"}}};
  for (std::size_t seed = 0; seed < breaks_at.size(); ++seed)
    for (std::size_t v = 0; v < 6; ++v) {
      Cell cell;
      cell.scenario = "field";
      cell.values["outliers"] = bench.variables[0].values[fewer_is_worse ? 5 - v : v];
      cell.choices["method"] = "robust";
      cell.seed = seed;
      cell.status = "done";
      cell.measures["worst"] = v >= breaks_at[seed] ? 1.0 : 0.001;
      bench.cells.push_back(cell);
    }
  return bench;
}

TEST(Breakdown, HalfOfTheSitesHoldUpToTheMedian) {
  const auto found = breakdowns(bench_of({3, 3, 4, 4, 4, 4, 5, 5, 6}), 0.95);
  ASSERT_EQ(found.size(), 2u) << "one for each tolerance";
  EXPECT_EQ(found[0].sites, 9u);
  EXPECT_EQ(found[0].median, 4u);
  EXPECT_EQ(breakdown_text(found[0]), "up to 0.3 (0.2 to 0.4)");
  EXPECT_THAT(breakdown_sentences(found),
              ElementsAre("as outliers goes from 0 to 0.5 on field, half of the sites stay within 2 mm up to 0.3 (0.2 "
                          "to 0.4) with robust."));
}

/// Ranks of the interval of a median as textbooks have them (Conover, table A3): 2 and 8 of 9, 6 and 15 of 20.
TEST(Breakdown, TheIntervalIsThatOfAMedian) {
  std::vector<std::size_t> ends(20, 6);
  for (std::size_t i = 0; i < 5; ++i) ends[i] = 1;
  EXPECT_EQ(breakdowns(bench_of(ends), 0.95)[0].lower, 6u);
  ends[5] = 1;
  EXPECT_EQ(breakdowns(bench_of(ends), 0.95)[0].lower, 1u);
  const auto few = breakdowns(bench_of({1, 2, 3, 4, 5}), 0.95)[0];
  EXPECT_FALSE(few.has_interval()) << "the least of five is below the median with 97 % only";
  EXPECT_EQ(breakdown_text(few), "up to 0.2");
}

TEST(Breakdown, WhatHoldsAgainBehindIsNoMerit) {
  Bench bench = bench_of({6, 6, 6, 6, 6, 6, 6});
  for (Cell& cell : bench.cells)
    if (cell.values["outliers"] == "0.2") cell.status = "failed";
  EXPECT_EQ(breakdown_text(breakdowns(bench, 0.95)[0]), "up to 0.1");
}

TEST(Breakdown, FewerMayBeWorse) {
  const auto found = breakdowns(bench_of({2, 2, 2, 2, 2, 2, 2}, true), 0.95);
  EXPECT_THAT(found[0].values, ElementsAre("0.5", "0.4", "0.3", "0.2", "0.1", "0"));
  EXPECT_EQ(breakdown_text(found[0]), "up to 0.4");
}

TEST(Breakdown, EndsAreSaid) {
  EXPECT_EQ(breakdown_text(breakdowns(bench_of({6, 6, 6, 6, 6, 6, 6}), 0.95)[0]), "through 0.5");
  EXPECT_EQ(breakdown_text(breakdowns(bench_of({0, 0, 0, 0, 0, 0, 0, 0}), 0.95)[0]), "not even at 0");
  EXPECT_EQ(breakdown_text(breakdowns(bench_of({0, 0, 0, 0, 0, 0, 0, 6}), 0.95)[0]), "not even at 0 (below 0 to 0.5)");
}

TEST(Breakdown, SitesThatHaveNotRunAreNotCounted) {
  Bench bench = bench_of({4, 4, 4, 4, 4, 4, 4});
  for (Cell& cell : bench.cells)
    if (cell.seed < 2 && cell.values["outliers"] == "0.3") cell.status = "missing";
  EXPECT_EQ(breakdowns(bench, 0.95)[0].sites, 5u);
}

/// A bench that was cut off has run the first values of all sites: those that broke there are known, and those that
/// hold so far were left away. Once "up to 0.1" of sites of which two thirds held at 0.2, where the run ended.
TEST(Breakdown, SitesThatHoldSoFarAreNotLeftAway) {
  Bench bench = bench_of({2, 2, 2, 2, 6, 6, 6, 6, 6, 6, 6, 6});
  for (Cell& cell : bench.cells)
    if (cell.values["outliers"] >= "0.3") cell.status = "missing";
  const auto found = breakdowns(bench, 0.95);
  EXPECT_EQ(found[0].sites, 4u);
  EXPECT_EQ(found[0].open, 8u);
  EXPECT_EQ(breakdown_text(found[0]), "at least up to 0.2 (0.1 to 0.5)");
  EXPECT_THAT(breakdown_sentences(found)[0], HasSubstr("; of up to 8 sites the next value has not run yet."));
}

/// What the bench excludes will never run: the sites end before it. Once "at least up to 0.3", and "of up to 7 sites
/// the next value has not run yet".
TEST(Breakdown, WhatIsExcludedIsNotOpen) {
  Bench bench = bench_of({6, 6, 6, 6, 6, 6, 6});
  std::erase_if(bench.cells, [](const Cell& cell) { return cell.values.at("outliers") >= "0.4"; });
  Bench middle = bench_of({6, 6, 6, 6, 6, 6, 6});
  std::erase_if(middle.cells, [](const Cell& cell) { return cell.values.at("outliers") == "0.2"; });
  const auto found = breakdowns(bench, 0.95);
  EXPECT_EQ(found[0].open, 0u);
  EXPECT_EQ(found[0].sites, 7u);
  EXPECT_EQ(breakdown_text(found[0]), "through 0.3");
  EXPECT_THAT(breakdown_sentences(found)[0],
              HasSubstr("through 0.3 with robust; with robust the bench leaves out 0.4 and "
                        "0.5."));
  EXPECT_EQ(breakdown_text(breakdowns(middle, 0.95)[0]), "through 0.5");
  std::erase_if(bench.cells, [](const Cell& cell) { return cell.values.at("outliers") >= "0.2"; });
  EXPECT_TRUE(breakdowns(bench, 0.95).empty()) << "two values are no curve";
}

/// Once judged by its RMSE, which is within.
TEST(Breakdown, ATrialOfWhichTheLargestErrorIsNotKnownDoesNotHold) {
  Bench bench = bench_of({6, 6, 6, 6, 6, 6, 6});
  for (Cell& cell : bench.cells) {
    cell.measures["error"] = 0.001;
    if (cell.values["outliers"] == "0.4") cell.measures["worst"] = std::nan("");
  }
  EXPECT_EQ(breakdown_text(breakdowns(bench, 0.95)[0]), "up to 0.3");
  for (Cell& cell : bench.cells) cell.measures.erase("worst");
  EXPECT_THAT(breakdown_sentences(breakdowns(bench, 0.95))[0],
              HasSubstr("; by their RMSE, because no largest error is measured"));
}

/// `breaks_at` by alternative: at the first tolerance, and at the second.
Bench alternatives_of(const std::map<std::string, std::pair<std::size_t, std::size_t>>& breaks_at,
                      const std::vector<std::string>& places) {
  Bench bench = bench_of({6, 6, 6, 6, 6, 6, 6});
  std::vector<Cell> cells;
  for (const std::string& place : places)
    for (const auto& [name, ends] : breaks_at)
      for (Cell cell : bench.cells) {
        const auto v = static_cast<std::size_t>(10 * std::stod(cell.values["outliers"]) + 0.5);
        cell.scenario = place, cell.choices["method"] = name;
        cell.measures["worst"] = v >= ends.second ? 1.0 : v >= ends.first ? 0.004 : 0.001;
        cells.push_back(cell);
      }
  bench.cells = cells;
  return bench;
}

/// Once four sentences of ten names each, "not even at 4 with ..., ..., ...".
TEST(Breakdown, SentencesTellWhereAlternativesDifferAndPlacesThatAgreeShareOne) {
  const auto tell = [](const std::map<std::string, std::pair<std::size_t, std::size_t>>& ends) {
    return breakdown_sentences(breakdowns(alternatives_of(ends, {"exact", "noisy"}), 0.95));
  };
  EXPECT_THAT(tell({{"a", {0, 3}}, {"b", {0, 5}}}),
              ElementsAre("as outliers goes from 0 to 0.5 on exact / noisy, half of the sites stay within 5 mm up to "
                          "0.4 with b. Up to 0.2 with a."));
  EXPECT_THAT(tell({{"a", {0, 0}}, {"b", {0, 0}}}),
              ElementsAre("as outliers goes from 0 to 0.5 on exact / noisy, nobody stays within 2 mm on half of the "
                          "sites, even at 0."));
}

/// Once "nobody stays within 2 mm ..., even at 0", of two of which one broke at once and the other has not run on.
TEST(Breakdown, NobodyIsSaidOfAllAndNotOfTheFirst) {
  Bench bench = alternatives_of({{"a", {0, 0}}, {"b", {0, 0}}}, {"field"});
  for (Cell& cell : bench.cells)
    if (cell.choices["method"] == "b" && cell.seed > 2 && cell.values["outliers"] != "0.5") cell.status = "missing";
  const auto found = breakdowns(bench, 0.95);
  ASSERT_GT(found.size(), 1u);
  EXPECT_EQ(found[1].median, 0u);
  EXPECT_GT(found[1].at_most, 0u);
  EXPECT_THAT(breakdown_sentences(found)[0], testing::Not(HasSubstr("nobody")));
}

/// Nothing of it breaks.
TEST(Breakdown, WhatCannotRunHasNone) {
  Bench bench = alternatives_of({{"a", {3, 3}}, {"never", {3, 3}}}, {"field"});
  for (Cell& cell : bench.cells)
    if (cell.choices["method"] == "never") cell.status = "failed", cell.planned = false;
  for (const Breakdown& found : breakdowns(bench, 0.95)) EXPECT_EQ(found.name, "a");
}

TEST(Breakdown, OnlyOfVariablesThatAreNumbers) {
  Bench bench = bench_of({3, 3, 3});
  for (Cell& cell : bench.cells) cell.values["outliers"] += " of all";
  for (std::string& value : bench.variables[0].values) value += " of all";
  EXPECT_TRUE(breakdowns(bench, 0.95).empty());
}

}  // namespace test_breakdown
}  // namespace plumbline::bench

// Which alternative a bench tells people to take.
#include <gmock/gmock.h>

#include <cmath>

#include "show/bench/analysis.hpp"
#include "show/bench/page.hpp"
#include "show/bench/sentences.hpp"
#include "show/bench/tables.hpp"

namespace plumbline::bench {
namespace test_choice {

using testing::HasSubstr;
using testing::Not;

/// Two registrations of sites without and with many outliers. `wrong`: the error of least squares where there are many
/// [m], which always answers; of 24 trials the robust one answers in `answered`, 1 mm off.
Bench bench_of(double wrong, std::size_t answered) {
  Bench bench;
  bench.tolerances = {0.002, 0.1};
  bench.rope = 0.00005;
  bench.groups = {{"method", {"least squares", "robust"}, {"registration"}, false}};
  for (const char* place : {"clean", "spoilt"})
    for (std::size_t seed = 0; seed < 24; ++seed)
      for (const std::string& name : bench.groups[0].alternatives) {
        const bool spoilt = std::string(place) == "spoilt";
        Cell cell;
        cell.scenario = cell.place = place;
        cell.choices["method"] = name;
        cell.seed = seed;
        cell.status = spoilt && name == "robust" && seed >= answered ? "failed" : "done";
        cell.error = "no agreement";
        const double noise = 1e-6 * static_cast<double>((seed * 7) % 5);
        cell.measures["error"] = cell.measures["worst"] =
            spoilt && name == "least squares" ? wrong + noise : 0.001 + noise;
        bench.cells.push_back(cell);
      }
  return bench;
}

std::string choice(const Bench& bench) { return choices_to_make(bench, analyse(bench)).at(0); }

TEST(Choice, AnAnswerThatIsOffByDecimetresDoesNotWinOverNone) {
  const std::string said = choice(bench_of(0.5, 3));
  EXPECT_THAT(said, Not(HasSubstr("take least squares"))) << said;
  EXPECT_THAT(said, Not(HasSubstr("obust is beaten"))) << said;
  EXPECT_THAT(said, HasSubstr("Off by more than 100 mm: least squares in 24 of 48 cells")) << said;
  for (const Sentence& sentence : verdicts(bench_of(0.5, 3), analyse(bench_of(0.5, 3))))
    EXPECT_FALSE(sentence.winner) << sentence.text;
}

TEST(Choice, AnAnswerOfUseWinsOverNone) {
  const std::string said = choice(bench_of(0.001, 3));
  EXPECT_THAT(said, HasSubstr("take least squares, beaten nowhere. Robust is beaten on spoilt, for lack of results"));
}

TEST(Choice, WhatIsOfNoUseInMostCellsIsNotTaken) {
  Bench bench = bench_of(0.5, 24);
  for (Cell& cell :
       bench.cells) {  // both wrong, one of them a little less; only one clean trial says what is asked for
    if (cell.seed == 0 && cell.place == "clean") continue;
    cell.status = "done";
    cell.measures["error"] += cell.choices["method"] == "robust" ? 0.3 : 0.6;
  }
  const std::string said = choice(bench);
  EXPECT_THAT(said, Not(HasSubstr("take robust"))) << said;
  EXPECT_THAT(said, HasSubstr("of use in fewer than half of the cells")) << said;
}

TEST(Choice, WhereNoAnswerIsWithinTheTolerancesTheyAreNoYardstick) {
  Bench bench = bench_of(0.001, 3);
  for (Cell& cell : bench.cells) cell.measures["error"] += 5;  // say, pixels
  EXPECT_THAT(choice(bench), HasSubstr("take least squares, beaten nowhere"));
}

/// Of four trials nothing is compared, also where both gave the same in each.
TEST(Choice, OfTooFewTrialsThatAgreeNobodyIsNamed) {
  Bench bench = bench_of(0.001, 24);
  std::erase_if(bench.cells, [](const Cell& cell) { return cell.seed >= 4; });
  const std::string said = choice(bench);
  EXPECT_THAT(said,
              testing::StrEq("method: of least squares and robust nothing can be said: too few trials to compare."));
}

/// Six alternatives on six places, each worse than the one before: what is to be said of many is said in many
/// sentences, and no two of them say the same of somebody else.
TEST(Choice, IsSaidInSentencesThatAPersonWouldSay) {
  Bench bench;
  bench.tolerances = {0.002, 0.1};
  bench.rope = 0.00005;
  bench.groups = {{"solver", {}, {"pose"}, false}};
  for (int a = 0; a < 6; ++a) bench.groups[0].alternatives.push_back("solver number " + std::to_string(a));
  for (int p = 0; p < 6; ++p)
    for (std::size_t seed = 0; seed < 12; ++seed)
      for (int a = 0; a < 6; ++a) {
        Cell cell;
        cell.scenario = cell.place = "a place with a name of many words, number " + std::to_string(p);
        cell.choices["solver"] = bench.groups[0].alternatives[a];
        cell.seed = seed;
        cell.status = a > 4 && seed == 0 && p < a ? "failed" : "done";
        cell.error = "no agreement";
        // Every other place is one where all do the same; the best on the others is the worst on the first.
        const double step = p == 0 ? 5 - a : p % 2 ? a / 2 : 0;
        cell.measures["error"] = cell.measures["worst"] = 0.001 + 0.001 * step + 1e-6 * static_cast<double>(seed % 5);
        bench.cells.push_back(cell);
      }
  const std::string said = choice(bench);
  std::size_t words = 0, longest = 0, sentences = 0;
  for (std::size_t k = 0; k + 1 < said.size(); ++k) {
    words += said[k] == ' ';
    if (said.compare(k, 2, ". ") == 0) ++sentences, words = 0;
    longest = std::max(longest, words);
  }
  EXPECT_LE(longest, 40u) << said;
  EXPECT_GE(sentences, 4u) << said;
  EXPECT_THAT(said, HasSubstr("none is best everywhere. Solver number")) << said;
  EXPECT_THAT(said, HasSubstr("nearest, beaten on 1 of 6 places.")) << said;
}

/// evaluate.cost counts what an alternative rejected, too: 3.78e6 to 4.23e6 in a table reads as a solver that diverged.
TEST(Choice, ACostThatGoesUpIsToldInWordsWhereverItStands) {
  Bench bench = bench_of(0.001, 24);
  for (Cell& cell : bench.cells) cell.measures["start_cost"] = 3.784e6, cell.measures["final_cost"] = 2e6;
  for (const auto& text : {to_markdown(bench, analyse(bench)), to_html(bench, analyse(bench))})
    EXPECT_THAT(text, Not(HasSubstr("Costs that go up"))) << "none does";
  for (Cell& cell : bench.cells)
    if (cell.place == "spoilt" && cell.choices["method"] == "robust") cell.measures["final_cost"] = 4.231e6;
  const Analysis analysis = analyse(bench);
  const std::string words =
      "spoilt, robust: the cost of all observations went up in 24 of 24 trials (the first from 3.784e+06 to "
      "4.231e+06): what was minimised leaves some of them out or damps them, or the solver diverged";
  EXPECT_THAT(analysis.rising, testing::ElementsAre(words));
  EXPECT_THAT(to_markdown(bench, analysis), HasSubstr("\n## Costs that go up\n\n- " + words + ".\n"));
  EXPECT_THAT(to_html(bench, analysis), HasSubstr("<summary>Costs that go up</summary>"));
  EXPECT_THAT(to_html(bench, analysis), HasSubstr("<li class=\"bad\">" + words + "</li>"));
  EXPECT_THAT(to_json(bench, analysis), HasSubstr("\"rising_costs\": [\n  \"" + words + "\"\n ]"));
}

/// Rounding is no rise, and a trial that failed has no cost.
TEST(Choice, ACostThatStaysIsNotSaidToRise) {
  Bench bench = bench_of(0.001, 20);
  for (Cell& cell : bench.cells) {
    cell.measures["start_cost"] = 100;
    cell.measures["final_cost"] = cell.status == "done" ? 100 * (1 + 1e-12) : 200;
  }
  EXPECT_THAT(analyse(bench).rising, testing::IsEmpty());
}

/// Rows are told apart by what was chosen, not by how it reads.
TEST(Rows, NamesThatReadAlikeAreRowsOfTheirOwn) {
  Bench bench;
  bench.groups = {{"first", {"a", "a · b"}, {}, false}, {"second", {"b · c", "c"}, {}, false}};
  for (const auto& [first, second] : {std::pair<std::string, std::string>{"a", "b · c"}, {"a · b", "c"}})
    for (std::size_t seed = 0; seed < 8; ++seed) {
      Cell cell;
      cell.choices = {{"first", first}, {"second", second}};
      cell.seed = seed, cell.status = "done";
      cell.measures["error"] = first == "a" ? 0.001 + 1e-6 * static_cast<double>(seed) : 0.002;
      bench.cells.push_back(cell);
    }
  const Analysis found = analyse(bench);
  ASSERT_EQ(found.rows.size(), 2u);
  EXPECT_EQ(found.rows[0].summary.trials, 8u);
}

/// A mean over the others would be one of other trials: it is not there, and that is said.
TEST(Rows, AMeasureThatSomeTrialsLackIsNamed) {
  Bench bench = bench_of(0.001, 24);
  bench.metrics = {{"error", "errors.rmse_z"}, {"predicted", "errors.predicted_rmse_z"}};
  for (Cell& cell : bench.cells)
    if (cell.choices["method"] == "robust") cell.measures["predicted"] = cell.seed % 2 == 0 ? 0.001 : std::nan("");
  const Analysis found = analyse(bench);
  EXPECT_THAT(
      found.unused,
      testing::Contains("measure predicted (errors.predicted_rmse_z) has no value in some trials of 2 rows (the "
                        "first: clean, robust), which therefore have none"));
}

}  // namespace test_choice
}  // namespace plumbline::bench

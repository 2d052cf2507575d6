// Which alternative a bench tells people to take.
#include <gmock/gmock.h>

#include "show/bench/analysis.hpp"
#include "show/bench/sentences.hpp"

namespace plumbline::bench {
namespace {

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
  EXPECT_THAT(said, Not(HasSubstr("robust is beaten"))) << said;
  EXPECT_THAT(said, HasSubstr("off by more than 100 mm: least squares in 24 of 48 cells")) << said;
  for (const Sentence& sentence : verdicts(bench_of(0.5, 3), analyse(bench_of(0.5, 3))))
    EXPECT_FALSE(sentence.winner) << sentence.text;
}

TEST(Choice, AnAnswerOfUseWinsOverNone) {
  const std::string said = choice(bench_of(0.001, 3));
  EXPECT_THAT(said, HasSubstr("take least squares, beaten nowhere; robust is beaten on spoilt, for lack of results"));
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

/// evaluate.cost counts what an alternative rejected, too: 3.78e6 to 4.23e6 in a table reads as a solver that diverged.
TEST(Choice, ACostThatGoesUpIsToldInWords) {
  Bench bench = bench_of(0.001, 24);
  for (Cell& cell : bench.cells) {
    cell.measures["start_cost"] = 3.784e6;
    cell.measures["final_cost"] = cell.place == "spoilt" && cell.choices["method"] == "robust" ? 4.231e6 : 2e6;
  }
  EXPECT_THAT(analyse(bench).rising,
              testing::ElementsAre("spoilt, robust: the cost of all observations went up in 24 of 24 trials (the first "
                                   "from 3.784e+06 to 4.231e+06): what was minimised leaves some of them out or damps "
                                   "them, or the solver diverged"));
}

}  // namespace
}  // namespace plumbline::bench

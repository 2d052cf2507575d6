// What counts for an alternative and what does not: cells that never ran, results that another one's own test forbids,
// covariances that state something else than what is found.
#include <gmock/gmock.h>

#include <cmath>

#include "show/bench/analysis.hpp"
#include "show/bench/page.hpp"
#include "show/bench/sentences.hpp"
#include "show/bench/tables.hpp"

namespace plumbline::bench {
namespace test_merit {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;
using testing::StrEq;

/// 16 trials at each of two places; `change` sets what is not "done, 1 mm off, give or take a tenth".
template <typename Change>
Bench bench_of(const std::vector<std::string>& names, const Change& change) {
  Bench bench;
  bench.rope = 0.00005;
  bench.tolerances = {0.002, 0.1};
  bench.groups = {{"adjuster", names, {}, false}};
  for (const char* place : {"calm", "noisy"})
    for (std::size_t seed = 1; seed <= 16; ++seed)
      for (const std::string& name : names) {
        Cell cell;
        cell.scenario = cell.place = place;
        cell.choices["adjuster"] = name;
        cell.seed = seed, cell.status = "done";
        cell.measures["error"] = cell.measures["worst"] = 0.001 + 1e-5 * static_cast<double>((seed * 7) % 5);
        change(cell);
        bench.cells.push_back(cell);
      }
  return bench;
}

std::string choice(const Bench& bench) { return choices_to_make(bench, analyse(bench)).at(0); }

void cannot_run(Cell& cell) {
  cell.status = "failed", cell.planned = false, cell.error = "no pipeline", cell.measures.clear();
}

/// Once "take adjust.ceres, beaten nowhere", of the only one that ran, and "100.0 % (61.0-100.0)" of the other.
TEST(Merit, WhatNeverRanIsNoOpponent) {
  const Bench bench = bench_of({"shur", "ceres"}, [](Cell& cell) {
    if (cell.choices["adjuster"] == "shur") cannot_run(cell);
  });
  const Analysis analysis = analyse(bench);
  EXPECT_THAT(choice(bench), StrEq("adjuster: nothing to choose: only ceres ran. shur did not run."));
  EXPECT_EQ(analysis.open, 0u) << "a bench with looks waits for no result that cannot come";
  EXPECT_THAT(to_markdown(bench, analysis), HasSubstr("| calm | shur | 0 | 0 | – |"));
  EXPECT_THAT(to_markdown(bench, analysis), HasSubstr("| did not run |"));
  EXPECT_THAT(to_markdown(bench, analysis), Not(HasSubstr("100.0 %")));
  EXPECT_THAT(to_html(bench, analysis), HasSubstr(">did not run</td>"));
  EXPECT_THAT(to_json(bench, analysis), HasSubstr("\"did_not_run\": 16"));
  EXPECT_THAT(analysis.unused, ElementsAre("adjuster=shur gave no result: it did not run, because no pipeline can be "
                                           "made of any of its 32 cells; the first: no pipeline"));
}

TEST(Merit, OthersAreComparedWithoutIt) {
  Bench bench = bench_of({"a", "b", "shur"}, [](Cell& cell) {
    if (cell.choices["adjuster"] == "shur") cannot_run(cell);
    if (cell.choices["adjuster"] == "b") cell.measures["error"] *= 3;
  });
  EXPECT_THAT(choice(bench), StartsWith("adjuster: take a, beaten nowhere. b is beaten on calm / noisy, by up to 2."));
  EXPECT_THAT(choice(bench), HasSubstr("shur did not run."));
  for (Cell& cell : bench.cells)
    if (cell.choices["adjuster"] == "b" && cell.status == "done") cell.measures["error"] /= 3;
  EXPECT_THAT(choice(bench), StartsWith("adjuster: nothing separates a and b: they gave the same in every trial"));
}

/// One that runs and gives nothing is beaten by one that does, as before.
TEST(Merit, WhatRanAndFailedHasLost) {
  const Bench bench = bench_of({"frail", "sure"}, [](Cell& cell) {
    if (cell.choices["adjuster"] == "frail" && cell.seed > 2) cell.status = "failed", cell.error = "no agreement";
  });
  EXPECT_THAT(choice(bench), StartsWith("adjuster: take sure, beaten nowhere. frail is beaten on calm / noisy, for "
                                        "lack of results"));
}

/// schur tests its control and forbids what contradicts it; colmap knows none. `nees`: of colmap, 8 of 8 if it holds.
Bench tested_and_untested(double nees) {
  return bench_of({"schur", "colmap"}, [nees](Cell& cell) {
    const bool schur = cell.choices["adjuster"] == "schur";
    if (schur || std::isfinite(nees)) cell.measures["nees"] = schur ? 8 : nees, cell.measures["freedom"] = 8;
    if (!schur || cell.place != "noisy") return;
    cell.status = "failed", cell.forbidden = true;
    cell.error = "node 'block' says of its result that it is not to be used (invalid)";
  });
}

/// Once "take colmap, beaten nowhere. schur is beaten on noisy, for lack of results".
TEST(Merit, WhoHasNoTestDoesNotWinByIt) {
  const Bench bench = tested_and_untested(std::nan(""));
  EXPECT_THAT(choice(bench), Not(HasSubstr("take")));
  EXPECT_THAT(choice(bench), Not(HasSubstr("beaten")));
  EXPECT_THAT(choice(bench), HasSubstr("schur forbids by its own test 16 results on noisy that colmap gives with no "
                                       "NEES to judge them by: more results are no merit there."));
  EXPECT_THAT(verdicts(bench, analyse(bench)).at(0).text,
              HasSubstr("noisy (16 more results, which the other one's own test forbids)"));
  EXPECT_THAT(choice(tested_and_untested(40)),
              HasSubstr("that colmap gives with covariances that state too little: more"));
}

TEST(Merit, WhoseCovarianceHoldsWinsByMoreResults) {
  EXPECT_THAT(choice(tested_and_untested(8)),
              StartsWith("adjuster: take colmap, beaten nowhere. schur is beaten on noisy, for lack of results."));
}

/// One place, 40 seeds: schur forbids 16, and of the other 24 the errors are `apart` [m] off, by four times of that
/// more or less.
Bench forbidding_some(double apart) {
  Bench bench = bench_of({"schur", "colmap"}, [](Cell&) {});
  bench.cells.clear();
  for (std::size_t seed = 1; seed <= 40; ++seed)
    for (const char* name : {"schur", "colmap"}) {
      Cell cell;
      const bool schur = std::string(name) == "schur";
      cell.choices["adjuster"] = name, cell.seed = seed, cell.status = "done";
      cell.measures["error"] = cell.measures["worst"] =
          0.001 + (schur ? 0 : apart * (1 + 6 * std::sin(2.4 * static_cast<double>(seed))));
      if (schur && seed <= 16) cell.status = "failed", cell.forbidden = true, cell.measures.clear();
      bench.cells.push_back(cell);
    }
  return bench;
}

/// Once "nothing separates colmap and schur: they are equal within 0.05 mm", and a bench with looks stopped.
TEST(Merit, ErrorsThatNothingIsShownOfAreNotEqual) {
  const Bench apart = forbidding_some(0.0001), near = forbidding_some(1e-6);
  const Analysis analysis = analyse(apart);
  ASSERT_TRUE(analysis.duels.at(0).untested);
  EXPECT_THAT(choice(apart), HasSubstr("no winner. "));
  EXPECT_THAT(choice(apart), HasSubstr("seeds would show"));
  EXPECT_THAT(choice(apart), Not(HasSubstr("equal within")));
  EXPECT_EQ(analysis.open, 1u);
  EXPECT_THAT(choice(near), HasSubstr("they are equal within 0.05 mm"));
  EXPECT_EQ(analyse(near).open, 0u);
}

/// Once "colmap beats schur: it gives a result 16 times more", the class "win" and no more, of a bench of one place.
TEST(Merit, TheVerdictBetweenTwoSaysItOfOnePlaceToo) {
  const Bench bench = forbidding_some(1e-6);
  const auto sentence = verdicts(bench, analyse(bench)).at(0);
  EXPECT_THAT(sentence.text, HasSubstr("the other one's own test forbids, so more results are no merit"));
  EXPECT_FALSE(sentence.winner);
  EXPECT_THAT(to_json(bench, analyse(bench)), HasSubstr("so more results are no merit"));
}

/// What both refuse nobody has lost: once 25 of these outweighed ten crashes, and colmap "gave" them.
TEST(Merit, OnlyWhatTheOtherOneGivesIsLost) {
  Bench bench = forbidding_some(1e-6);
  for (Cell& cell : bench.cells) {
    const bool schur = cell.choices["adjuster"] == "schur";
    if (cell.seed > 35) continue;
    if (cell.seed > 25 && !schur) continue;
    cell.status = "failed", cell.forbidden = cell.seed <= 25, cell.measures.clear();
  }
  const Analysis analysis = analyse(bench);
  EXPECT_EQ(lost_cells(bench, analysis.duels.at(0), "schur").size(), 10u);
  EXPECT_FALSE(analysis.duels.at(0).untested);
  EXPECT_THAT(choice(bench), HasSubstr("schur is beaten, for lack of results"));
  EXPECT_THAT(choice(bench), Not(HasSubstr("forbids")));
}

/// Sigmas 5 % too large lie outside the band of 960 degrees of freedom, and nobody is misled by them.
TEST(Merit, WhoStatesMoreThanIsFoundIsOnTheSafeSide) {
  const auto stating = [](double nees) {
    Bench bench = forbidding_some(1e-6);
    for (Cell& cell : bench.cells)
      if (cell.status == "done") {
        cell.measures["nees"] = 24 * nees, cell.measures["freedom"] = 24;
        cell.measures["predicted"] = cell.error_size() / std::sqrt(nees);
      }
    return analyse(bench).duels.at(0).untested;
  };
  EXPECT_FALSE(stating(0.9));
  EXPECT_FALSE(stating(1.1)) << "within a tenth, as the tables call it right";
  EXPECT_TRUE(stating(2));
}

/// A failure for any other reason is a loss.
TEST(Merit, OnlyItsOwnTestExcusesIt) {
  Bench bench = tested_and_untested(std::nan(""));
  for (Cell& cell : bench.cells) cell.forbidden = false;
  EXPECT_THAT(choice(bench), StartsWith("adjuster: take colmap, beaten nowhere. schur is beaten on noisy"));
}

/// Once on bench.md only.
TEST(Merit, WhatIsStatedInTwoTrialsIsInBothPages) {
  Bench bench = bench_of({"a", "b"}, [](Cell& cell) { cell.measures["nees"] = 8, cell.measures["freedom"] = 8; });
  std::erase_if(bench.cells, [](const Cell& cell) { return cell.seed > 2; });
  const Analysis analysis = analyse(bench);
  EXPECT_THAT(to_markdown(bench, analysis), HasSubstr("not judged"));
  EXPECT_THAT(to_html(bench, analysis), HasSubstr("not judged"));
}

/// Two with the same errors, of which one states a sixth of its error of scale.
Bench stated_wrong() {
  return bench_of({"honest", "bold"}, [](Cell& cell) {
    const double found = 1e-4 * (1 + 0.1 * static_cast<double>(cell.seed % 3));
    const double stated = cell.choices["adjuster"] == "honest" ? found : found / 6;
    cell.modes["scale"] = {
        {"found", found}, {"predicted", stated}, {"nees", found * found / stated / stated}, {"freedom", 1}};
    cell.modes["tilt"] = {{"found", found}, {"predicted", found}, {"nees", 1}, {"freedom", 1}};
  });
}

/// Once in bench.json only.
TEST(Merit, EveryPartOfTheErrorsIsOnThePages) {
  const Bench bench = stated_wrong();
  const Analysis analysis = analyse(bench);
  for (const std::string& text : {to_markdown(bench, analysis), to_html(bench, analysis)})
    for (const char* part : {"scale", "tilt", "predicted / found", "too little", "right"})
      EXPECT_THAT(text, HasSubstr(part));
  EXPECT_THAT(to_markdown(bench, analysis), HasSubstr("| calm | bold | scale | 0.16"));
}

/// Once "nothing separates honest and bold" and no more.
TEST(Merit, WhoStatesItsErrorsWrongIsNamedAmongEquals) {
  EXPECT_THAT(choice(stated_wrong()), HasSubstr("Of their own errors bold states too much or too little (what "
                                                "covariances state says where), honest does not."));
}

}  // namespace test_merit
}  // namespace plumbline::bench

// What counts as a trial and as its result, what is compared with what, and when a bench may stop.
#include "bench_program.hpp"

namespace plumbline::test {
namespace test_trials {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using Json = nlohmann::json;

const std::string two = "seeds: 1-8\nalternatives: {method: {good: {}, worse: {solver.with.factor: 1.5}}}\n";

/// A mean over places is a number about the list of places: nothing is said of it unless weights are stated.
TEST(Bench, OverAllPlacesNothingIsSaidWithoutWeights) {
  BenchProgram plumbline;
  const std::string rest =
      "seeds: 1-8\nmatrix: {factor: [1, 2]}\nscenarios: {a: {}, b: {solver.with.milliseconds: 1}}\nalternatives: "
      "{method: {good: {solver.with.own: 0}, "
      "worse: {solver.with.own: 0.5}}}\n";
  plumbline.write("trial.yaml",
                  "plumbline: 1\nvars: {seed: 1, factor: 1}\nnodes:\n  site: {use: story.draw}\n"
                  "  solver: {use: trial.judged, in: {site: site.number}, with: {factor: \"${factor}\"}}\n");
  plumbline.bench_file(rest);
  plumbline.run();
  Json overall = plumbline.summary()["comparisons"][0];
  EXPECT_TRUE(overall["place"].is_null());
  EXPECT_TRUE(overall.contains("spread"));
  EXPECT_FALSE(overall.contains("verdict"));
  EXPECT_THAT(read_file(plumbline.work() / "out/b/bench.md"), HasSubstr("the file states no weights"));
  plumbline.bench_file(rest + "weights: {a: 1, b: 3}\n");
  plumbline.run();
  overall = plumbline.summary()["comparisons"][0];
  EXPECT_TRUE(overall.contains("verdict"));
  EXPECT_THAT(plumbline.summary()["verdicts"][0].get<std::string>(), HasSubstr("weighing a 1, b 3, "));
}

/// Start and final cost are those of the node that the role names, not what a solver says of itself.
TEST(Bench, ComputesTheCostsThatTheRoleOfWhatIsComparedNames) {
  BenchProgram plumbline;
  plumbline.bench_file(
      "seeds: 1-8\nalternatives: {method: {good: {solver.use: trial.judged}, worse: {solver.use: trial.judged, "
      "solver.with.factor: 1.5}}}\n");
  const Json counts = plumbline.run();
  EXPECT_EQ(counts["failed"], 0) << plumbline.answer.err;
  EXPECT_EQ(counts["merged"], 8 * 6);  // site, start cost; solver and final cost of either
  const Json summary = plumbline.summary();
  ASSERT_EQ(summary["rows"].size(), 2u);
  const Json &good = summary["rows"][0], &worse = summary["rows"][1];
  EXPECT_GT(good["start_cost"].get<double>(), 1000);
  EXPECT_EQ(good["start_cost"], worse["start_cost"]);
  EXPECT_NEAR(worse["final_cost"].get<double>() / good["final_cost"].get<double>(), 1.5 * 1.5, 1e-9);
  EXPECT_THAT(summary["verdicts"][0].get<std::string>(), HasSubstr("good beats worse"));
  EXPECT_THAT(read_file(plumbline.work() / "out/b/bench.md"), HasSubstr("| start cost | final cost |"));
  EXPECT_THAT(read_file(plumbline.work() / "out/b/bench.csv"), HasSubstr(",final_cost,start_cost,"));
}

/// What a solver assumes is part of what it is judged by.
TEST(Bench, TheJudgeIsToldWhatTheSolverWasTold) {
  BenchProgram plumbline;
  plumbline.bench_file(
      "seeds: 1\nalternatives: {method: {a: {solver.use: trial.judged}, told: {solver.use: trial.judged, "
      "solver.with.own: 0.25}}}\n");
  plumbline.run();
  const Json summary = plumbline.summary();
  const Json& told = summary["rows"][1];
  const double rmse = told["rmse"]["value"];
  EXPECT_NEAR(told["final_cost"].get<double>() - 1e6 * rmse * rmse, 0.25, 1e-6);
}

TEST(Bench, OfTooFewTrialsNothingIsSaid) {
  BenchProgram plumbline;
  plumbline.bench_file("seeds: 1\nalternatives: {method: {good: {}, worse: {solver.with.factor: 1.5}}}\n");
  plumbline.run();
  EXPECT_THAT(plumbline.summary()["choices"][0].get<std::string>(), HasSubstr("of good and worse nothing can be said"));
}

TEST(Bench, AComparisonFromDifferentStartsIsRefused) {
  BenchProgram plumbline;
  plumbline.write("trial.yaml",
                  "plumbline: 1\nvars: {seed: 1}\nnodes:\n  site: {use: story.draw}\n  other: {use: story.draw}\n"
                  "  solver: {use: trial.plain, in: {site: site.number}}\n");
  plumbline.bench_file(
      "seeds: 1-8\nalternatives: {solver: {mine: {solver.with.factor: 0.5}, "
      "theirs: {solver.in.site: other.number}}}\n");
  plumbline.run();
  const Json duel = plumbline.summary()["comparisons"][0];
  EXPECT_THAT(duel["refused"].get<std::string>(), HasSubstr("did not get the same inputs"));
  EXPECT_FALSE(duel.contains("verdict"));
}

/// In later rounds each goes on from what it did itself: what a loop starts from is what its first round gets.
TEST(Bench, LoopsAreComparedByWhatTheirFirstRoundGets) {
  BenchProgram plumbline;
  plumbline.write("trial.yaml",
                  "plumbline: 1\nvars: {seed: 1}\n"
                  "rounds: {carry: {state: {first: site.number, next: solver.error}}, most: 3}\n"
                  "nodes:\n  site: {use: story.draw}\n  solver: {use: trial.plain, in: {site: rounds.state}}\n");
  plumbline.bench_file(
      "seeds: 1-8\nalternatives: {solver: {mine: {solver.with.factor: 1e6}, theirs: {solver.with.factor: 2e6}}}\n");
  plumbline.run();
  const Json duel = plumbline.summary()["comparisons"][0];
  EXPECT_FALSE(duel.contains("refused")) << duel;
  EXPECT_EQ(duel["pairs"], 8) << duel;
  EXPECT_THAT(plumbline.summary()["verdicts"][0].get<std::string>(), HasSubstr("mine beats theirs by"));
}

/// By the cost that the bench computes where they start; alternatives of nodes before are compared by where they lead.
TEST(Bench, AComparisonFromDifferentCostsIsRefusedInWords) {
  BenchProgram plumbline;
  const std::string nodes =
      "plumbline: 1\nvars: {seed: 1}\nnodes:\n  site: {use: story.draw}\n  other: {use: story.draw}\n"
      "  between: {use: trial.plain, in: {site: site.number}}\n"
      "  solver: {use: trial.judged, in: {site: site.number}}\n";
  plumbline.write("trial.yaml", nodes);
  plumbline.bench_file(
      "seeds: 1-8\nalternatives: {solver: {mine: {solver.with.factor: 0.5}, "
      "theirs: {solver.in.site: other.number}}}\n");
  plumbline.run();
  EXPECT_THAT(plumbline.summary()["comparisons"][0]["refused"].get<std::string>(),
              HasSubstr("they started from different costs, "));
  EXPECT_THAT(plumbline.summary()["verdicts"][0].get<std::string>(),
              HasSubstr("mine and theirs are not compared: they started from different costs"));
  plumbline.bench_file(
      "seeds: 1-8\nalternatives: {start: {one: {between.with.own: 0}, other: {between.with.own: 1}}, "
      "solver: {mine: {solver.in.site: between.error, solver.with.factor: 0.5}, theirs: {solver.in.site: "
      "between.error}}}\n");
  plumbline.run();
  ASSERT_EQ(plumbline.summary()["comparisons"].size(), 2u);
  const Json summary = plumbline.summary();
  for (const Json& duel : summary["comparisons"]) EXPECT_FALSE(duel.contains("refused")) << duel;
}

/// Each look has its share of the error probability, so that stopping when something is shown keeps the level.
TEST(Bench, StopsAtTheFirstLookAtWhichEverythingIsDecided) {
  BenchProgram plumbline;
  plumbline.bench_file(
      "seeds: 1-40\nstop: {when: decided, after: [10, 40]}\nalternatives: {method: {good: {}, worse: "
      "{solver.with.factor: "
      "1.5}}}\n");
  Json counts = plumbline.run();
  EXPECT_EQ(plumbline.answer.code, 0) << plumbline.answer.err;
  EXPECT_EQ(counts["done"], 20);
  EXPECT_EQ(plumbline.results().size(), 20u);
  EXPECT_NEAR(plumbline.summary()["confidence"].get<double>(), 0.975, 1e-12);
  EXPECT_THAT(plumbline.summary()["verdicts"][0].get<std::string>(), HasSubstr("good beats worse"));
  plumbline.bench_file(
      "seeds: 1-12\nstop: {when: decided, after: [6, 12]}\nalternatives: {method: {a: {solver.with.own: 0.0003}, b: "
      "{solver.with.own: 0.00031}}}\n");
  counts = plumbline.run();
  EXPECT_EQ(counts["done"], 24) << "without a rope nothing is equal, and they are too alike for a winner";
}

/// Cells of a run that was cut off, or of another file, are no look of their own: with them a bench would be looked at
/// where its error probability has no share, as often as it is started again.
TEST(Bench, ALookSeesItsSeedsAndNoOthers) {
  BenchProgram plumbline;
  const std::string rest = "alternatives: {method: {good: {}, worse: {solver.with.factor: 1.5}}}\n";
  plumbline.bench_file("seeds: 1-25\n" + rest);
  plumbline.run();
  plumbline.bench_file("seeds: 1-40\nstop: {when: decided, after: [10, 20, 40]}\n" + rest);
  const auto trials = [&](const std::string& page) {
    return Json::parse(read_file(plumbline.work() / page / "bench.json"))["rows"][0]["trials"];
  };
  EXPECT_EQ(plumbline({"bench", "b.yaml", "--status", "--out", "out/status"}).code, 1);
  EXPECT_EQ(trials("out/status"), 20) << "the last look that is complete";
  plumbline.run();
  EXPECT_EQ(trials("out/b"), 10);
  const std::string text = read_file(plumbline.work() / "out/b/bench.md");
  EXPECT_THAT(text, HasSubstr("80 cells with 40 different seeds: 20 finished, 0 failed, 30 not run yet; judged at the "
                              "look at the first 10 seeds, without 30 cells of later ones that have run"));
  EXPECT_THAT(read_file(plumbline.work() / "out/b/bench.svg"), HasSubstr("with its 98.3 % interval"));
}

TEST(Bench, WhereNothingIsComparedNothingIsDecided) {
  BenchProgram plumbline;
  plumbline.bench_file("seeds: 1-12\nstop: {when: decided, after: [6, 12]}\n");
  EXPECT_EQ(plumbline.run()["done"], 12);
}

/// Once "beats by 0.25 mm (0.25 to 0.25)" of thirty times the same trial.
TEST(Bench, SeedsThatChangeNothingAreOneTrial) {
  BenchProgram plumbline;
  plumbline.write("trial.yaml",
                  "plumbline: 1\nvars: {seed: 1}\nnodes:\n  site: {use: story.constant, with: {value: 7}}\n"
                  "  solver: {use: trial.plain, in: {site: site.number}}\n");
  plumbline.bench_file("seeds: 1-30\nalternatives: {method: {good: {}, worse: {solver.with.factor: 1.5}}}\n");
  plumbline.run();
  const Json summary = plumbline.summary();
  EXPECT_THAT(summary["verdicts"][0].get<std::string>(),
              HasSubstr("nothing can be said of good and worse: all 30 seeds gave the same, so they are one trial"));
  EXPECT_THAT(summary["choices"][0].get<std::string>(), Not(HasSubstr("take good")));
  EXPECT_TRUE(summary["rows"][0]["rmse"]["lower"].is_null());
  EXPECT_EQ(summary["rows"][0]["trials"], 1);
  EXPECT_THAT(plumbline.answer.err, HasSubstr("warning: all 30 seeds gave the same: nothing there hangs on the seed"));
}

/// An alternative that is added later runs in another hour: who is faster then is not known.
TEST(Bench, TimesOfDifferentRunsAreNotCompared) {
  BenchProgram plumbline;
  plumbline.bench_file("seeds: 1-12\nalternatives: {method: {slow: {solver.with.milliseconds: 4}}}\n");
  plumbline.run();
  const std::string both =
      "seeds: 1-12\nalternatives: {method: {slow: {solver.with.milliseconds: 4}, fast: {solver.with.factor: 1.5}}}\n";
  plumbline.bench_file(both);
  plumbline.run();
  EXPECT_THAT(plumbline.summary()["comparisons"][0]["time_words"].get<std::string>(),
              HasSubstr("their times are of different runs, so they are not compared"));
  BenchProgram together;
  together.bench_file(both);
  together.run();
  // What they then are hangs on what else the machine does.
  EXPECT_THAT(together.summary()["comparisons"][0]["time_words"].get<std::string>(),
              testing::AllOf(Not(testing::IsEmpty()), Not(HasSubstr("different runs"))));
}

/// Once decided by the first two seeds: where those read the same, every other trial had the number of the first one.
TEST(Bench, WhatASeedNamesIsItsOwnAlsoWhereTwoSeedsNameTheSame) {
  BenchProgram plumbline;
  const auto pipeline = [](const std::string& factor) {
    return "plumbline: 1\nvars: {seed: 1, share: \"" + factor +
           "\"}\nnodes:\n  site: {use: story.draw}\n"
           "  solver: {use: trial.plain, in: {site: site.number}, with: {factor: \"${share}\"}}\n";
  };
  plumbline.write("trial.yaml", pipeline("0.${seed}"));
  plumbline.bench_file("seeds: [1, 10, 2, 3]\n");
  EXPECT_EQ(plumbline.run()["failed"], 0) << plumbline.answer.err;
  for (const std::string seed : {"1", "2", "3"}) {
    plumbline.write("trial.yaml", pipeline("0." + seed));
    plumbline.bench_file("seeds: " + seed + "\n");
    EXPECT_EQ(plumbline.run()["found"], 1) << "seed " << seed << " ran with what another one names";
  }
}

/// Once "take never, beaten nowhere" of an alternative whose every result `plumbline run` forbids to use.
TEST(Bench, AResultThatIsNotToBeUsedIsLost) {
  BenchProgram plumbline;
  plumbline.bench_file(
      "seeds: 1-12\nalternatives: {method: {sound: {}, never: {solver.with.refuses: 1, solver.with.factor: 0.1}}}\n");
  EXPECT_EQ(plumbline.run()["failed"], 12);
  EXPECT_EQ(plumbline.answer.code, 1);
  const Json summary = plumbline.summary();
  EXPECT_THAT(summary["choices"][0].get<std::string>(), Not(HasSubstr("take never")));
  EXPECT_EQ(summary["failures"][0]["reason"], "node 'solver' says of its result that it is not to be used (invalid)");
}

/// What is measured beside the error takes nothing from it.
TEST(Bench, ABoundThatIsNotToBeUsedTakesNothingFromTheResult) {
  BenchProgram plumbline;
  plumbline.write("trial.yaml",
                  "plumbline: 1\nvars: {seed: 1}\nnodes:\n  site: {use: story.draw}\n"
                  "  solver: {use: trial.plain, in: {site: site.number}}\n"
                  "  limit: {use: trial.plain, in: {site: site.number}, with: {refuses: 1}}\n");
  plumbline.write("b.yaml",
                  "bench: 1\npipeline: trial.yaml\nmeasure: {error: solver.rmse_z, bound: limit.rmse_z}\nseeds: 1-2\n");
  EXPECT_EQ(plumbline.run()["failed"], 0);
}

TEST(Bench, RoundsThatCameToNoEndAreLost) {
  BenchProgram plumbline;
  plumbline.write("trial.yaml",
                  "plumbline: 1\nvars: {seed: 1}\n"
                  "rounds: {carry: {state: {first: site.number, next: solver.error}}, until: solver.rmse_z < 0, "
                  "most: 3}\n"
                  "nodes:\n  site: {use: story.draw}\n  solver: {use: trial.plain, in: {site: rounds.state}}\n");
  plumbline.bench_file("seeds: 1-2\n");
  EXPECT_EQ(plumbline.run()["failed"], 2) << plumbline.answer.err;
  EXPECT_THAT(plumbline.summary()["failures"][0]["reason"].get<std::string>(),
              HasSubstr("its rounds did not come to an end"));
}

/// Once the metric of the last item, as if it were that of the trial.
TEST(Bench, AMetricOfEachItemIsNoNumberOfATrial) {
  BenchProgram plumbline;
  plumbline.write("trial.yaml",
                  "plumbline: 1\nvars: {seed: 1}\nnodes:\n  sites: {use: story.series}\n"
                  "  solver: {use: trial.plain, each: site, in: {site: sites.numbers}}\n");
  plumbline.bench_file("seeds: 1-2\n");
  EXPECT_EQ(plumbline.run()["failed"], 2);
  EXPECT_THAT(plumbline.summary()["failures"][0]["reason"].get<std::string>(),
              HasSubstr("node 'solver' runs once for each item of its input 'site' and gives one each time"));
}

TEST(Bench, OneItemThatIsNotToBeUsedIsEnough) {
  for (const std::string values : {"[1, 2, 3, 4, 5, 6]", "[6, 5, 4, 3, 2, 1]"}) {
    BenchProgram plumbline;
    plumbline.write("trial.yaml",
                    "plumbline: 1\nvars: {seed: 1}\nnodes:\n  sites: {use: story.series, with: {values: " + values +
                        "}}\n  parts: {use: trial.plain, each: site, in: {site: sites.numbers}, with: {refuses: 0.5}}\n"
                        "  all: {use: story.sum, in: {numbers: parts.error}}\n"
                        "  solver: {use: trial.plain, in: {site: all.sum}}\n");
    plumbline.bench_file("seeds: 1\n");
    EXPECT_EQ(plumbline.run()["failed"], 1) << values;
    EXPECT_EQ(plumbline.summary()["failures"][0]["reason"],
              "node 'parts' says of its result that it is not to be used (invalid)");
  }
}

/// A scenario's pipeline was passed over without a word: its places were those of the bench's own.
TEST(Bench, AScenarioMayHaveAPipelineOfItsOwn) {
  BenchProgram plumbline;
  plumbline.write("twice.yaml",
                  "plumbline: 1\nvars: {seed: 1}\nnodes:\n  site: {use: story.draw}\n"
                  "  solver: {use: trial.plain, in: {site: site.number}, with: {factor: 2}}\n");
  plumbline.bench_file("seeds: 1-8\nscenarios: {own: {}, other: {pipeline: twice.yaml}}\n");
  plumbline.run();
  EXPECT_EQ(plumbline.answer.code, 0) << plumbline.answer.err;
  const Json rows = plumbline.summary()["rows"];
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_NEAR(rows[1]["rmse"]["value"].get<double>(), 2 * rows[0]["rmse"]["value"].get<double>(), 1e-12);
  plumbline.bench_file("seeds: 1-2\nscenarios: {own: {}, other: {pipeline: none.yaml}}\n");
  EXPECT_THAT(plumbline({"bench", "b.yaml"}).err, HasSubstr("there is no pipeline"));
  // Only one of the two could hold.
  plumbline.bench_file(
      "seeds: 1-2\nscenarios: {other: {pipeline: twice.yaml}}\nalternatives: {method: {a: {}, b: "
      "{pipeline: trial.yaml}}}\n");
  EXPECT_THAT(plumbline({"bench", "b.yaml"}).err, HasSubstr("'pipeline' is set to"));
}

/// Rows side by side are compared by eye, whatever the verdicts are of.
TEST(Bench, RowsOfDifferentTrialsAreMarked) {
  BenchProgram plumbline;
  plumbline.bench_file(two);
  plumbline.run();
  EXPECT_THAT(read_file(plumbline.work() / "out/b/bench.md"), Not(HasSubstr("and with * another row")));
  plumbline.bench_file("seeds: 1-8\nalternatives: {method: {good: {}, frail: {solver.with.fails: 0.5}}}\n");
  plumbline.run();
  EXPECT_THAT(read_file(plumbline.work() / "out/b/bench.md"),
              HasSubstr("and with * another row of its place finished"));
}

}  // namespace test_trials
}  // namespace plumbline::test

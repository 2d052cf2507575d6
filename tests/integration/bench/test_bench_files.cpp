// Bench files that are wrong: all that is wrong at once, with its place.
#include "bench_program.hpp"

namespace plumbline::test {
namespace test_bench_files {

using testing::HasSubstr;

Answer refused(const std::string& text) {
  const BenchProgram plumbline;
  plumbline.write("b.yaml", text);
  const Answer answer = plumbline({"bench", "b.yaml"});
  EXPECT_EQ(answer.code, 2) << answer.out << answer.err;
  EXPECT_FALSE(std::filesystem::exists(plumbline.work() / "out"));
  return answer;
}

TEST(BenchFile, AllThatIsWrongComesAtOnceWithItsPlace) {
  const Answer answer = refused(
      "bench: 1\npipeline: nowhere.yaml\nrope: 0.05\nseeds: 5-1\nmatrx: {}\n"
      "measure: {error: rmse}\nexclude: [{scenari: x}]\nkeep: some\n");
  for (const char* part :
       {"b.yaml:2:11: there is no pipeline", "b.yaml:3:7: '0.05' is no length", "b.yaml:4:8: seeds are",
        "b.yaml:5:1: a bench file has no key 'matrx' — did you mean 'matrix'?", "b.yaml:6:18: a metric is NODE.METRIC",
        "has no key 'scenari' — did you mean 'scenario'?", "b.yaml:8:7: 'keep' is"})
    EXPECT_THAT(answer.err, HasSubstr(part));
}

TEST(BenchFile, NoBenchFileNoYamlNoFile) {
  EXPECT_THAT(refused("plumbline: 1\nnodes: {}\n").err, HasSubstr("the first line is 'bench: 1'"));
  EXPECT_THAT(refused("bench: [1\n").err, HasSubstr("b.yaml:2"));
  EXPECT_THAT(refused("- a\n- b\n").err, HasSubstr("a bench file is a map"));
  const BenchProgram plumbline;
  EXPECT_THAT(plumbline({"bench", "none.yaml"}).err, HasSubstr("none.yaml"));
}

TEST(BenchFile, TwiceTheSameSeedValueOrAlternative) {
  EXPECT_THAT(refused("bench: 1\npipeline: trial.yaml\nseeds: [1-3, 2]\n").err, HasSubstr("without repetition"));
  EXPECT_THAT(refused("bench: 1\npipeline: trial.yaml\nmatrix: {factor: [1, 1]}\n").err,
              HasSubstr("has a value twice"));
  EXPECT_THAT(refused("bench: 1\npipeline: trial.yaml\nalternatives: {solver: [a, a]}\n").err, HasSubstr("twice"));
}

/// Once 960 cells that failed one by one.
TEST(BenchFile, APipelineThatTakesNoSeedIsRefused) {
  BenchProgram plumbline;
  plumbline.write(
      "trial.yaml",
      "plumbline: 1\nnodes:\n  site: {use: story.draw}\n  solver: {use: trial.plain, in: {site: site.number}}\n");
  plumbline.bench_file("seeds: 1-60\n");
  const Answer answer = plumbline({"bench", "b.yaml"});
  EXPECT_EQ(answer.code, 2);
  EXPECT_THAT(answer.err, HasSubstr("b.yaml:4:8: "));
  EXPECT_THAT(answer.err,
              HasSubstr("trial.yaml has no variable 'seed', so each of the 60 seeds would be the same trial"));
}

/// Once 60 failed cells, and a failure rate of an alternative that never was.
TEST(BenchFile, AKindThatFillsNoPlaceIsRefused) {
  BenchProgram plumbline;
  plumbline.bench_file("seeds: 1-2\nalternatives: {slover: {a: trial.plain}}\n");
  EXPECT_THAT(plumbline({"bench", "b.yaml"}).err,
              HasSubstr("b.yaml:5:25: no pipeline of this bench has a node or a role 'slover' that 'trial.plain' could "
                        "fill — did you mean 'solver'?"));
  plumbline.write("trial.yaml",
                  "plumbline: 1\nvars: {seed: 1}\nnodes:\n  site: {use: story.draw}\n"
                  "  solver: {use: trial.judged, in: {site: site.number}}\n");
  plumbline.bench_file(
      "seeds: 1-2\nalternatives: {solver: {a: story.constant}, way: {x: {solver.use: story.constant}}}\n");
  const Answer answer = plumbline({"bench", "b.yaml"});
  EXPECT_THAT(answer.err, HasSubstr("'story.constant' has the role 'source', but 'solver' is filled by the role "
                                    "'trial_solver' (trial.judged): it cannot stand there"));
  EXPECT_THAT(answer.err, HasSubstr("but node 'solver' is one of the role 'trial_solver'"));
  EXPECT_FALSE(std::filesystem::exists(plumbline.work() / "out"));
}

TEST(BenchFile, WeightsAreNumbersOfAllScenarios) {
  EXPECT_THAT(refused("bench: 1\npipeline: trial.yaml\nscenarios: {a: {}, b: {}}\nweights: {a: 1, c: 2}\n").err,
              testing::AllOf(HasSubstr("has no key 'c'"), HasSubstr("does not say how much scenario 'b' weighs")));
  EXPECT_THAT(refused("bench: 1\npipeline: trial.yaml\nscenarios: {a: {}}\nweights: {a: -1}\n").err,
              HasSubstr("b.yaml:4:14: a weight is a number above zero; found '-1'"));
}

TEST(BenchFile, AnExclusionThatNeverAppliesIsAnError) {
  EXPECT_THAT(refused("bench: 1\npipeline: trial.yaml\nmatrix: {factor: [1, 2]}\nexclude: [{factor: 3}]\n").err,
              HasSubstr("'factor' never is '3'"));
}

TEST(BenchFile, WhatHoldsInNoCombinationIsRefusedWithItsPlace) {
  const Answer answer = refused(
      "bench: 1\npipeline: trial.yaml\nseeds: 1-2\nscenarios:\n  sound: {factor: 2}\n  slip: {facter: 2}\n"
      "matrix: {fcator: [1, 2]}\nalternatives: {method: {a: {}, b: {solver.with.factr: 2, solvr.with.factor: 2}}}\n");
  EXPECT_THAT(answer.err, HasSubstr("b.yaml:6:10: 'facter=2' holds in no combination: this pipeline has no variable "
                                    "'facter' — did you mean 'factor'?"));
  EXPECT_THAT(answer.err, HasSubstr("b.yaml:7:10: 'fcator=1' holds in no combination"));
  EXPECT_THAT(answer.err, HasSubstr("b.yaml:8:36: 'solver.with.factr=2' holds in no combination"));
  EXPECT_THAT(answer.err, HasSubstr("b.yaml:8:58: 'solvr.with.factor=2' holds in no combination"));
  EXPECT_THAT(answer.err, testing::Not(HasSubstr("'factor=2'")));
}

/// What is set twice holds as one of them says and stands under both names: once "far, factor=1" with factor 1, and a
/// command line of which nothing came.
TEST(BenchFile, WhatIsSetTwiceIsRefusedWithBothPlaces) {
  BenchProgram plumbline;
  plumbline.bench_file(
      "seeds: 1-2\nscenarios:\n  far: {factor: 2}\nmatrix: {factor: [1, 2]}\n"
      "alternatives: {method: {a: {}, b: {factor: 3}}}\n");
  Answer answer = plumbline({"bench", "b.yaml"});
  EXPECT_EQ(answer.code, 2) << answer.out;
  EXPECT_THAT(answer.err, HasSubstr("b.yaml:7:10: 'factor' is set to '1' here and to '2' by scenario 'far': only one"));
  EXPECT_THAT(answer.err, HasSubstr("b.yaml:8:36: 'factor' is set to '3' here and to '2' by scenario 'far'"));
  plumbline.bench_file("seeds: 1-2\nscenarios: {near: {factor: 3}}\n");
  answer = plumbline({"bench", "b.yaml", "factor=1"});
  EXPECT_EQ(answer.code, 2) << answer.out;
  EXPECT_THAT(answer.err, HasSubstr("'factor' is set to '3' here and to '1' by the command line"));
  EXPECT_EQ(plumbline({"bench", "b.yaml", "factor=3"}).code, 0) << "they agree";
  plumbline.bench_file("seeds: 1-2\nmatrix: {seed: [1, 2]}\n");
  EXPECT_THAT(plumbline({"bench", "b.yaml"}).err, HasSubstr("b.yaml:5:10: 'seed' is set to '1' here"));
  plumbline.bench_file("seeds: 1-2\n");
  EXPECT_THAT(plumbline({"bench", "b.yaml", "seed=7"}).err, HasSubstr("b.yaml:4:8: 'seed' is set to"));
  plumbline.bench_file(
      "seeds: 1-2\nscenarios: {far: {factor: 2}, near: {}}\nalternatives: {method: {a: {}, b: {factor: 3}}}\n"
      "exclude: [{scenario: far, method: b}]\n");
  EXPECT_EQ(plumbline({"bench", "b.yaml"}).code, 0) << "where they would meet is excluded";
}

/// A variable and the parameter that it feeds: once "take mine", of one error under four names.
TEST(BenchFile, AVariableAndTheParameterItFeedsAreSetOnce) {
  BenchProgram plumbline;
  plumbline.bench_file(
      "seeds: 1-2\nmatrix: {factor: [1, 2]}\nalternatives: {method: {plain: {}, mine: {solver.with.factor: 1}}}\n");
  Answer answer = plumbline({"bench", "b.yaml"});
  EXPECT_EQ(answer.code, 2) << answer.out;
  EXPECT_THAT(answer.err, HasSubstr("b.yaml:5:10: 'factor=2' of the matrix reaches nothing: all that takes it is set "
                                    "by 'solver.with.factor=1' of 'mine' of method"));
  EXPECT_THAT(answer.err, testing::Not(HasSubstr("'factor=1' of the matrix"))) << "they agree";
  plumbline.bench_file("seeds: 1-2\nscenarios: {one: {factor: 1}, two: {factor: 2}}\n");
  answer = plumbline({"bench", "b.yaml", "solver.with.factor=3"});
  EXPECT_EQ(answer.code, 2) << answer.out;
  EXPECT_THAT(answer.err, HasSubstr("'factor=1' of scenario 'one' reaches nothing: all that takes it is set by "
                                    "'solver.with.factor=3' of the command line"));
  plumbline.bench_file(
      "seeds: 1-2\nalternatives:\n  one: {low: {factor: 1}, high: {factor: 2}}\n"
      "  two: {low: {solver.with.factor: 1}, high: {solver.with.factor: 3}}\n");
  EXPECT_THAT(plumbline({"bench", "b.yaml"}).err,
              HasSubstr("'factor=2' of 'high' of one reaches nothing: all that takes it is set by "
                        "'solver.with.factor=3' of 'high' of two"));
}

/// What the variable still reaches is another thing: a site as it is, and a solver that is told otherwise.
TEST(BenchFile, AVariableThatReachesSomethingElseMayBeToldOtherwise) {
  BenchProgram plumbline;
  plumbline.write("trial.yaml",
                  "plumbline: 1\nvars: {seed: 1, factor: 1, told: \"${factor}\"}\nnodes:\n  site: {use: story.draw}\n"
                  "  first: {use: trial.plain, in: {site: site.number}, with: {factor: \"${factor}\"}}\n"
                  "  solver: {use: trial.plain, in: {site: first.error}, with: {factor: \"${told}\"}}\n");
  plumbline.bench_file(
      "seeds: 1-2\nmatrix: {factor: [1, 2]}\n"
      "alternatives: {method: {plain: {}, wrong: {solver.with.factor: 3}, also: {told: 4}}}\n");
  EXPECT_EQ(plumbline({"bench", "b.yaml"}).code, 0);
}

/// Once weighed three times and two times.
TEST(BenchFile, TwoPlacesThatAreOneAreRefused) {
  BenchProgram plumbline;
  plumbline.bench_file(
      "seeds: 1-2\nscenarios: {p: {factor: 1}, q: {factor: 1}, s: {factor: 2}}\nweights: equal\n"
      "alternatives: {method: {a: {}, b: {solver.with.own: 1}}}\n");
  Answer answer = plumbline({"bench", "b.yaml"});
  EXPECT_EQ(answer.code, 2) << answer.out;
  EXPECT_THAT(answer.err, HasSubstr("scenario 'p' and scenario 'q' are the same trials under two names"));
  EXPECT_THAT(answer.err, testing::Not(HasSubstr("'s'")));
  plumbline.bench_file("seeds: 1-2\nmatrix: {factor: [1, 1.0, 1e0, 2]}\n");
  answer = plumbline({"bench", "b.yaml"});
  EXPECT_THAT(answer.err, HasSubstr("factor=1 and factor=1.0 are the same trials"));
  EXPECT_THAT(answer.err, HasSubstr("factor=1 and factor=1e0 are the same trials"));
}

TEST(BenchFile, OneNameIsOneThing) {
  const std::string head = "bench: 1\npipeline: trial.yaml\n";
  EXPECT_THAT(refused(head + "alternatives: {seed: {a: {}}}\n").err, HasSubstr("b.yaml:3:16: 'seed' is the name of"));
  EXPECT_THAT(refused(head + "matrix: {factor: [1]}\nalternatives: {factor: {a: {}}}\n").err,
              HasSubstr("'factor' is the name of something else of a cell"));
}

TEST(BenchFile, SeedsOfTheCommandLineTakeStopAwayAndSaySo) {
  BenchProgram plumbline;
  plumbline.bench_file("seeds: 1-4\nstop: {when: decided, after: [2, 4]}\n");
  EXPECT_THAT(plumbline({"bench", "b.yaml", "--seeds", "1-3"}).err,
              HasSubstr("warning: --seeds takes away the 'stop:' of b.yaml"));
  EXPECT_THAT(plumbline({"bench", "b.yaml"}).err, testing::Not(HasSubstr("takes away")));
}

/// Once the pipeline of the group whose name comes later, under the name of the other one, too.
TEST(BenchFile, TwoGroupsThatTakeAPipelineAreRefusedWhereTheyMeet) {
  BenchProgram plumbline;
  for (const char* name : {"one.yaml", "other.yaml"})
    plumbline.write(name,
                    "plumbline: 1\nvars: {seed: 1}\nnodes:\n  site: {use: story.draw}\n"
                    "  solver: {use: trial.plain, in: {site: site.number}}\n");
  plumbline.bench_file(
      "seeds: 1-2\nalternatives: {adjuster: {a: {}, b: {pipeline: one.yaml}}, fusion: {c: {}, d: {pipeline: "
      "other.yaml}}}\n");
  EXPECT_EQ(plumbline.run()["failed"], 2);
  EXPECT_THAT(plumbline.summary()["failures"][0]["reason"].get<std::string>(),
              HasSubstr("the groups 'adjuster' and 'fusion' both set pipeline"));
}

/// Once printed as millimetres, and the worst called the winner.
TEST(BenchFile, WhatIsMeasuredIsALength) {
  BenchProgram plumbline;
  plumbline.write("trial.yaml",
                  "plumbline: 1\nvars: {seed: 1}\nnodes:\n  site: {use: story.draw}\n"
                  "  solver: {use: trial.cost, in: {site: site.number}}\n");
  plumbline.write("b.yaml",
                  "bench: 1\npipeline: trial.yaml\nmeasure: {error: solver.cost}\nseeds: 1-8\n"
                  "alternatives: {method: {a: {}, b: {solver.with.assumed: 1}}}\n");
  EXPECT_EQ(plumbline.run()["failed"], 16);
  EXPECT_EQ(plumbline.answer.code, 1);
  EXPECT_THAT(plumbline.summary()["failures"][0]["reason"].get<std::string>(),
              HasSubstr("'solver.cost' is in '1': 'error' of a bench is a length in 'm', of which less is better"));
}

/// What one kind of node takes and another does not is no slip of the pen.
TEST(BenchFile, ACombinationThatIsNoPipelineIsAFailedCellWithItsReason) {
  BenchProgram plumbline;
  plumbline.bench_file(
      "seeds: 1-2\nscenarios: {s: {solver.with.own: 0.1}}\nalternatives: {solver: [trial.plain, trial.cost]}\n");
  EXPECT_EQ(plumbline.run()["failed"], 2);
  EXPECT_THAT(plumbline.summary()["failures"][0]["reason"].get<std::string>(), HasSubstr("'own'"));
}

TEST(BenchFile, AnOverrideThatNoPipelineTakesIsRefused) {
  BenchProgram plumbline;
  plumbline.bench_file("seeds: 1-2\n");
  const Answer answer = plumbline({"bench", "b.yaml", "facter=2"});
  EXPECT_EQ(answer.code, 2);
  EXPECT_THAT(answer.err, HasSubstr("'facter=2' holds in no combination"));
}

TEST(BenchFile, AMetricThatNoNodeGivesIsAFailedCell) {
  BenchProgram plumbline;
  plumbline.write("b.yaml", "bench: 1\npipeline: trial.yaml\nmeasure: {error: solver.rmsez}\nseeds: 1-2\n");
  plumbline.run();
  EXPECT_THAT(plumbline.summary()["failures"][0]["reason"].get<std::string>(), HasSubstr("no metric 'solver.rmsez'"));
  plumbline.write("b.yaml", "bench: 1\npipeline: trial.yaml\nmeasure: {error: solvr.rmse_z}\nseeds: 1-2\n");
  plumbline.run();
  EXPECT_THAT(plumbline.summary()["failures"][0]["reason"].get<std::string>(), HasSubstr("has no node 'solvr'"));
}

}  // namespace test_bench_files
}  // namespace plumbline::test

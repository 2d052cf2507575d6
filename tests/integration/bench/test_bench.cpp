// plumbline bench from outside: what is shared runs once, what failed is told every time, the order never matters.
#include "bench_program.hpp"
#include "runtime/base/digest.hpp"
#include "runtime/sweep/sweep_archive.hpp"

namespace plumbline::test {
namespace test_bench {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
namespace fs = std::filesystem;
using Json = nlohmann::json;

const std::string two = "seeds: 1-8\nalternatives: {method: {good: {}, worse: {solver.with.factor: 1.5}}}\n";

TEST(Bench, WhatAlternativesShareRunsOnceAndNothingRunsTwice) {
  BenchProgram plumbline;
  plumbline.bench_file(two);
  Json first = plumbline.run();
  EXPECT_EQ(plumbline.answer.code, 0) << plumbline.answer.err;
  EXPECT_EQ(first["cells"], 16);
  EXPECT_EQ(first["node_runs"], 32);  // two nodes a cell, one by one
  EXPECT_EQ(first["merged"], 24);     // the site of a seed is one node
  EXPECT_EQ(first["executed"], 24);
  const Json second = plumbline.run();
  EXPECT_EQ(second["found"], 16);
  EXPECT_EQ(second["node_runs"], 0);
  // One more alternative: its own node runs, the site comes from the store.
  plumbline.bench_file(
      "seeds: 1-8\nalternatives: {method: {good: {}, worse: {solver.with.factor: 1.5}, "
      "worst: {solver.with.factor: 2}}}\n");
  const Json third = plumbline.run();
  EXPECT_EQ(third["found"], 16);
  EXPECT_EQ(third["executed"], 8);
}

/// What is measured must be known: a plugin that is not used is named, once.
TEST(Bench, SaysWhichOfTwoPluginsItUses) {
  BenchProgram plumbline;
  plumbline.bench_file("seeds: 1-2\n");
  const fs::path other = plumbline.folder.path() / "other";
  fs::create_directory(other);
  fs::copy_file(PLUMBLINE_STORY_PLUGIN, other / fs::path(PLUMBLINE_STORY_PLUGIN).filename());
  plumbline.use_plugins(plumbline.plugins().string() + ":" + other.string());
  plumbline.run();
  EXPECT_EQ(plumbline.answer.code, 0) << plumbline.answer.err;
  const std::string words = "has one of that name, too, which is not used";
  const size_t first = plumbline.answer.err.find(words);
  EXPECT_NE(first, std::string::npos) << plumbline.answer.err;
  EXPECT_EQ(plumbline.answer.err.find(words, first + 1), std::string::npos) << plumbline.answer.err;
}

/// A part of a shipped bench, by the names that its file has; words behind --seeds that set something are overrides.
TEST(Bench, ScenariosThatAreNamedRunAloneWithWhatSpeaksOfThem) {
  BenchProgram plumbline;
  plumbline.bench_file(
      "seeds: 1-8\nscenarios: {one floor: {factor: 1}, 'far, dark': {factor: 2}, near: {factor: 3}}\n"
      "alternatives: {method: {good: {}, worse: {solver.with.own: 0.001}}}\nweights: {one floor: 1, 'far, dark': 3, "
      "near: 1}\n"
      "exclude: [{scenario: near, method: worse, why: it cannot}]\n");
  const Json all = plumbline.run({"--seeds", "1-3"});
  EXPECT_EQ(all["cells"], 15);
  const Json some = plumbline.run({"--scenario", "far, dark", "--scenario", "one floor", "--seeds", "1-3"});
  EXPECT_EQ(plumbline.answer.code, 0) << plumbline.answer.err;
  EXPECT_EQ(some["cells"], 12);
  EXPECT_EQ(some["found"], 12);  // the same cells as of the whole
  const Json other = plumbline.run({"--scenario", "near", "--seeds", "1", "factor=3"});
  EXPECT_EQ(plumbline.answer.code, 0) << plumbline.answer.err;
  EXPECT_EQ(other["cells"], 1);
  const auto refused = plumbline({"bench", "b.yaml", "--scenario", "one flor"});
  EXPECT_EQ(refused.code, 2);
  EXPECT_THAT(refused.err,
              HasSubstr("no scenario 'one flor' — did you mean 'one floor'?; it has 'one floor', 'far, dark', 'near'"));
}

TEST(Bench, TheOrderOfAlternativesAndOtherNamesForThemChangeNothing) {
  BenchProgram plumbline;
  plumbline.bench_file(two);
  plumbline.run();
  const Json before = plumbline.summary();
  plumbline.bench_file(
      "seeds: [8, 3, 1-2, 4-7]\nalternatives: {method: {worse: {solver.with.factor: 1.5}, good: {}}}\n");
  EXPECT_EQ(plumbline.run()["found"], 16);
  const Json after = plumbline.summary();
  EXPECT_EQ(before["comparisons"], after["comparisons"]);
  EXPECT_EQ(before["verdicts"], after["verdicts"]);
  plumbline.bench_file("seeds: 1-8\nalternatives: {way: {a: {}, b: {solver.with.factor: 1.50}}}\n");
  EXPECT_EQ(plumbline.run()["found"], 16);
}

TEST(Bench, WritesAllItsFilesAndTheVerdictInWords) {
  BenchProgram plumbline;
  plumbline.bench_file(two + "rope: 0.05 mm\ntitle: Good and worse\n");
  plumbline.run();
  for (const char* name : {"bench.html", "bench.csv", "bench.json", "bench.md", "bench.tex", "bench.svg", "bench.pdf"})
    EXPECT_TRUE(fs::exists(plumbline.work() / "out/b" / name)) << name;
  EXPECT_THAT(plumbline.summary()["verdicts"][0].get<std::string>(), HasSubstr("good beats worse by 0.3"));
  const std::string page = read_file(plumbline.work() / "out/b/bench.html");
  EXPECT_THAT(page, HasSubstr("good beats worse by"));
  EXPECT_THAT(page, Not(HasSubstr("http"))) << "a page that needs no network";
  const std::string tex = read_file(plumbline.work() / "out/b/bench.tex");
  EXPECT_THAT(tex, HasSubstr("bench@all/good/rmse"));
  const size_t table = tex.find("\\newcommand{\\benchtable}"), words = tex.find("\\newcommand{\\benchparagraph}");
  ASSERT_NE(table, std::string::npos);
  ASSERT_NE(words, std::string::npos);
  EXPECT_THAT(tex.substr(table, words - table), HasSubstr("\\toprule\nAlternative & Trials & Failed & RMSE [mm]"));
  EXPECT_THAT(tex.substr(table, words - table), HasSubstr("\ngood & "));
  EXPECT_THAT(tex.substr(words), HasSubstr("method: take good, beaten nowhere."));
  const std::string csv = read_file(plumbline.work() / "out/b/bench.csv");
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 17);
}

/// What ran is in the record, not only the file that asked for it.
TEST(Bench, TheRecordHasThePipelinesTheCommitAndTheLibraries) {
  BenchProgram plumbline;
  plumbline.write("part.yaml", "plumbline: 1\nnodes:\n  site: {use: story.draw}\n");
  plumbline.write(
      "other.yaml",
      "plumbline: 1\ninclude: [part.yaml]\nvars: {seed: 1}\nnodes:\n  solver: {use: trial.plain, in: {site: "
      "site.number}}\n");
  plumbline.bench_file("seeds: 1-2\nalternatives: {method: {plain: {}, other: {pipeline: other.yaml}}}\n");
  plumbline.run();
  const std::string record = read_file(plumbline.work() / "out/b/run.jsonl");
  const Json start = Json::parse(record.substr(0, record.find('\n')));
  std::set<std::string> names;
  for (const Json& source : start["sources"]) names.insert(fs::path(source["path"].get<std::string>()).filename());
  EXPECT_EQ(names, (std::set<std::string>{"b.yaml", "trial.yaml", "other.yaml", "part.yaml"}));
  const std::string machine = plumbline.summary()["machine"].dump();
  EXPECT_THAT(machine, HasSubstr(", commit "));
  EXPECT_THAT(machine, HasSubstr("GNU "));
  EXPECT_THAT(machine, HasSubstr("libtbb.so."));
}

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

TEST(Bench, TwoGroupsThatSetTheSameAreRefusedInWords) {
  BenchProgram plumbline;
  plumbline.bench_file(
      "seeds: 1-2\nalternatives: {solver: [trial.plain, trial.judged], method: {a: {}, b: {solver.use: "
      "trial.judged}}}\n");
  const Json counts = plumbline.run();
  EXPECT_EQ(counts["failed"], 4);
  EXPECT_THAT(plumbline.summary()["failures"][0]["reason"].get<std::string>(),
              HasSubstr("the groups 'method' and 'solver' both set solver.use"));
}

TEST(Bench, NamesAreNoFormulasInTheTable) {
  BenchProgram plumbline;
  plumbline.bench_file("seeds: 1-8\nalternatives: {way: {\"=a\": {}, b: {solver.with.factor: 1.50}}}\n");
  plumbline.run();
  const std::string csv = read_file(plumbline.work() / "out/b/bench.csv");
  EXPECT_THAT(csv, HasSubstr(",'=a,"));
  EXPECT_THAT(csv, Not(HasSubstr(",=a")));
}

/// Once a difference of 0.000 with an alternative that had no result, one macro for two names, and another time in the
/// table than on the page.
TEST(Bench, WhatDoesNotExistIsNoNumberAndNamesStayApart) {
  BenchProgram plumbline;
  plumbline.bench_file(
      "title: \"two\\n\\\\input{evil}\"\nseeds: 1-8\nalternatives: {method: {a_b: {}, a%b: {solver.with.factor: 1.5}, "
      "none: {solver.with.fails: 1}}}\n");
  plumbline.run();
  const std::string tex = read_file(plumbline.work() / "out/b/bench.tex");
  EXPECT_THAT(tex, Not(HasSubstr("\n\\input")));
  EXPECT_THAT(tex, HasSubstr("bench@all/a-b/rmse\\"));
  EXPECT_THAT(tex, HasSubstr("bench@all/a-b-2/rmse\\"));
  EXPECT_THAT(tex, testing::AnyOf(HasSubstr("bench@diff/all/a-b/a-b-2\\"), HasSubstr("bench@diff/all/a-b-2/a-b\\")));
  EXPECT_THAT(tex, Not(HasSubstr("/none\\endcsname")));
  const Json summary = plumbline.summary();
  for (const Json& duel : summary["comparisons"]) {
    if (duel["second"] != "none") continue;
    EXPECT_TRUE(duel["difference"]["value"].is_null());
  }
  const std::string choice = summary["choices"][0].get<std::string>();
  EXPECT_THAT(choice, HasSubstr("none gave no result in any of 8 cells"));
  EXPECT_THAT(choice, HasSubstr("take a_b, beaten nowhere. a%b is beaten by 0."));
}

TEST(Bench, OfTooFewTrialsNothingIsSaid) {
  BenchProgram plumbline;
  plumbline.bench_file("seeds: 1\nalternatives: {method: {good: {}, worse: {solver.with.factor: 1.5}}}\n");
  plumbline.run();
  EXPECT_THAT(plumbline.summary()["choices"][0].get<std::string>(), HasSubstr("of good and worse nothing can be said"));
}

TEST(Bench, AMeasureThatNoCellHasIsNamed) {
  BenchProgram plumbline;
  plumbline.write("b.yaml",
                  "bench: 1\npipeline: trial.yaml\nmeasure: {error: solver.rmse_z, bias: solver.bais_z}\nseeds: 1-2\n"
                  "alternatives: {method: {good: {}, worse: {solver.with.factor: 1.5}}}\n");
  plumbline.run();
  EXPECT_EQ(plumbline.summary()["unused"][0],
            "measure bias (solver.bais_z) has no value in any finished cell: is it spelt right?");
  EXPECT_THAT(plumbline.answer.err, HasSubstr("warning: measure bias (solver.bais_z) has no value"));
}

TEST(Bench, TheTableHasTheTimeOfThePage) {
  BenchProgram plumbline;
  plumbline.bench_file(
      "seeds: 1\nalternatives: {method: {good: {solver.use: trial.judged}, worse: {solver.use: trial.judged, "
      "solver.with.factor: 1.5}}}\n");
  plumbline.run();
  const Json rows = plumbline.summary()["rows"];
  const std::string csv = read_file(plumbline.work() / "out/b/bench.csv");
  for (const Json& row : rows) EXPECT_THAT(csv, HasSubstr("," + row["seconds"].dump() + ",")) << csv;
}

TEST(Bench, AFailedCellIsAResultWithItsReasonEveryTimeItIsShown) {
  BenchProgram plumbline;
  plumbline.bench_file("seeds: 1-10\nalternatives: {method: {sound: {}, weak: {solver.with.fails: 0.5}}}\n");
  for (int time = 0; time < 2; ++time) {
    const Json counts = plumbline.run();
    EXPECT_EQ(plumbline.answer.code, 0) << "a failed cell is a result";
    EXPECT_GT(counts["failed"], 0);
    EXPECT_LT(counts["failed"], 10);
    const Json summary = plumbline.summary();
    ASSERT_GE(summary["failures"].size(), 1u);
    EXPECT_EQ(summary["failures"][0]["name"], "weak");
    EXPECT_THAT(summary["failures"][0]["reason"].get<std::string>(), HasSubstr("is beyond this solver"));
    EXPECT_THAT(read_file(plumbline.work() / "out/b/bench.csv"), HasSubstr("is beyond this solver"));
    EXPECT_THAT(read_file(plumbline.work() / "out/b/bench.md"), HasSubstr("is beyond this solver"));
    // Failed trials count as failed at every tolerance.
    for (const Json& row : summary["rows"])
      EXPECT_EQ(row["failure_rates"].back()["failed"], row["choices"]["method"] == "weak" ? counts["failed"] : Json(0));
  }
  EXPECT_EQ(plumbline.run({"--retry"})["found"], 20 - plumbline.summary()["cells"]["failed"].get<int>());
}

/// A bench whose first node is a script that does `more` [Python] when it has run, once.
class ChangingBench : public BenchProgram {
 public:
  explicit ChangingBench(const std::string& more) {
    const auto own = folder.path() / "plugins";
    std::filesystem::copy(plugins(), own, std::filesystem::copy_options::recursive);
    std::ofstream(own / "pass.node.yaml")
        << "plumbline_node: 1\nkind: outside.pass\nversion: 1\nsummary: Hands on a number\n"
           "run: [/usr/bin/python3, pass.py]\ninputs: {number: {type: plumbline.Number/1, doc: a number}}\n"
           "outputs: {number: {type: plumbline.Number/1, doc: the same}}\n";
    const std::string once = (work() / "once").string();
    std::ofstream(own / "pass.py") << "from plumbline_artifacts import Call\nimport os, shutil\ncall = Call()\n"
                                      "number = call.inputs('number', 'plumbline.Number/1')[0].value\n"
                                      "call.commit('number', 'plumbline.Number/1', {'value': number})\n"
                                      "if not os.path.exists('"
                                   << once << "'):\n  open('" << once << "', 'w').close()\n  " << more << "\n";
    use_plugins(own);
    write("trial.yaml",
          "plumbline: 1\nvars: {seed: 1}\nnodes:\n  site: {use: story.draw}\n"
          "  pass: {use: outside.pass, in: {number: site.number}}\n"
          "  solver: {use: trial.plain, in: {site: pass.number}}\n");
    bench_file("seeds: 1-3\nalternatives: {method: {sound: {}, other: {solver.with.factor: 2}}}\n");
  }
};

/// What fails because somebody edits a node while cells run says nothing of the alternatives: as a failed cell it would
/// be counted as lost, now and whenever the bench is run again.
TEST(Bench, WhatFailsBecauseAPluginChangedIsNoResult) {
  ChangingBench plumbline("open(__file__, 'a').write('# edited\\n')");
  const Answer stopped = plumbline({"bench", "b.yaml", "--out", "out/b", "--workers", "1"});
  EXPECT_EQ(stopped.code, 1);
  EXPECT_THAT(stopped.err, HasSubstr("pass.py was changed while cells ran"));
  EXPECT_THAT(plumbline.results(), testing::IsEmpty()) << "a failure that is kept is counted as a loss for ever";
  const Json counts = plumbline.run();
  EXPECT_EQ(plumbline.answer.code, 0) << plumbline.answer.err;
  EXPECT_EQ(counts["done"], 6);
  EXPECT_EQ(counts["failed"], 0);
}

TEST(Bench, APluginLinkedAnewToTheSameBytesIsTheSame) {
  const std::string name = std::filesystem::path(PLUMBLINE_TRIAL_PLUGIN).filename();
  ChangingBench plumbline("library = os.path.join(os.path.dirname(__file__), '" + name +
                          "'); shutil.copy(library, library + '.new'); os.replace(library + '.new', library)");
  const Json counts = plumbline.run({"--workers", "1"});
  EXPECT_EQ(plumbline.answer.code, 0) << plumbline.answer.err;
  EXPECT_EQ(counts["done"], 6);
  EXPECT_EQ(counts["failed"], 0);
}

/// An evaluator in another language that hands on nothing: its metrics are what is compared.
TEST(Bench, AnEvaluatorInPythonIsMeasured) {
  BenchProgram plumbline;
  const auto own = plumbline.folder.path() / "plugins";
  std::filesystem::copy(plumbline.plugins(), own, std::filesystem::copy_options::recursive);
  std::ofstream(own / "off.node.yaml")
      << "plumbline_node: 1\nkind: outside.off\nversion: 1\nsummary: Tells a number\nrun: [/usr/bin/python3, off.py]\n"
         "inputs: {number: {type: plumbline.Number/1, doc: a number}}\noutputs: {}\n"
         "parameters: {factor: {kind: number, default: 1, unit: \"1\", minimum: 0, maximum: 9, doc: times}}\n";
  std::ofstream(own / "off.py") << "from plumbline_artifacts import Call\ncall = Call()\n"
                                   "value = call.inputs('number', 'plumbline.Number/1')[0].value\n"
                                   "call.metric('rmse', call.parameters['factor'] * abs(value), 'm')\n";
  plumbline.use_plugins(own);
  plumbline.write("p.yaml",
                  "plumbline: 1\nvars: {seed: 1}\nnodes:\n  site: {use: story.draw}\n"
                  "  off: {use: outside.off, in: {number: site.number}}\n");
  plumbline.write("b.yaml",
                  "bench: 1\npipeline: p.yaml\nmeasure: {error: off.rmse}\nseeds: 1-2\n"
                  "alternatives: {method: {one: {}, two: {off.with.factor: 2}}}\n");
  EXPECT_EQ(plumbline.run()["failed"], 0) << plumbline.answer.err;
  const Json rows = plumbline.summary()["rows"];
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_NEAR(rows[1]["rmse"]["value"].get<double>() / rows[0]["rmse"]["value"].get<double>(), 2, 1e-12);
}

TEST(Bench, AnAlternativeThatFailedInAllItsCellsWasNotMeasured) {
  BenchProgram plumbline;
  plumbline.bench_file("seeds: 1-4\nalternatives: {method: {sound: {}, weak: {solver.with.fails: 1}}}\n");
  plumbline.run({"-q"});
  EXPECT_EQ(plumbline.answer.code, 1);
  EXPECT_THAT(plumbline.answer.err, HasSubstr("method=weak gave no result: all cells failed"));
}

TEST(Bench, ACrashIsAFailedCellAndTheOthersGoOn) {
  BenchProgram plumbline;
  plumbline.bench_file("seeds: 1-12\nalternatives: {method: {sound: {}, deadly: {solver.with.crashes: 0.3}}}\n");
  const Json counts = plumbline.run({"--workers", "2"});
  EXPECT_EQ(counts["done"], 24);
  EXPECT_GT(counts["failed"], 0);
  EXPECT_LT(counts["failed"], 12);
  const Json summary = plumbline.summary();
  for (const Json& failure : summary["failures"]) {
    EXPECT_EQ(failure["name"], "deadly");
    EXPECT_THAT(failure["reason"].get<std::string>(),
                HasSubstr("node 'solver' (trial.plain): its process died of signal 11"));
  }
  EXPECT_THAT(plumbline.answer.err, Not(HasSubstr("crashed"))) << "one line a cell and no more: the table has it";
}

TEST(Bench, ManyAtOnceOnOneStoreAllWriteTheirTables) {
  BenchProgram plumbline;
  plumbline.bench_file("seeds: 1-20\nalternatives: {method: {good: {}, worse: {solver.with.factor: 1.5}}}\n");
  std::vector<std::thread> people;
  std::array<Answer, 6> answers;
  for (size_t i = 0; i < answers.size(); ++i)
    people.emplace_back([&, i] { answers[i] = plumbline({"bench", "b.yaml", "--out", "out/" + std::to_string(i)}); });
  for (auto& person : people) person.join();
  for (size_t i = 0; i < answers.size(); ++i) {
    EXPECT_EQ(answers[i].code, 0) << answers[i].err;
    EXPECT_TRUE(fs::exists(plumbline.work() / "out" / std::to_string(i) / "bench.html")) << i;
  }
}

TEST(Bench, AMeasureThatIsMistypedIsGuessed) {
  BenchProgram plumbline;
  plumbline.write("b.yaml", "bench: 1\npipeline: trial.yaml\nmeasure: {error: solver.rmsez}\nseeds: 1\n");
  plumbline.run();
  EXPECT_THAT(plumbline.summary()["failures"][0]["reason"].get<std::string>(),
              HasSubstr("it gave no metric 'solver.rmsez' — did you mean 'solver.rmse_z'?"));
}

TEST(Bench, ACellThatTakesTooLongIsEnded) {
  BenchProgram plumbline;
  plumbline.bench_file("seeds: 1-2\nalternatives: {method: {quick: {}, slow: {solver.with.milliseconds: 60000}}}\n");
  const Json counts = plumbline.run({"--limit", "2"});
  EXPECT_EQ(counts["failed"], 2);
  EXPECT_THAT(plumbline.summary()["failures"][0]["reason"].get<std::string>(),
              HasSubstr("node 'solver' (trial.plain): it took longer than 2 s"));
}

TEST(Bench, EveryAlternativeThatIsNamedAppears) {
  BenchProgram plumbline;
  plumbline.bench_file(
      "seeds: 1-3\nmatrix: {factor: [1, 2]}\n"
      "alternatives: {solver: [trial.plain, trial.unbuilt], mood: {calm: {}, never: {solver.with.own: 1}}}\n"
      "exclude: [{mood: never, why: it is never right}]\n");
  plumbline.run();
  const Json summary = plumbline.summary();
  ASSERT_EQ(summary["unused"].size(), 2u);
  for (const Json& verdict : summary["verdicts"])
    EXPECT_THAT(verdict.get<std::string>(), Not(HasSubstr("unbuilt"))) << "said once, not against everybody";
  EXPECT_THAT(summary["unused"][0].get<std::string>(), HasSubstr("solver=trial.unbuilt gave no result: all that ran"));
  EXPECT_THAT(summary["unused"][1].get<std::string>(), HasSubstr("mood=never gave no result: all its cells are excl"));
  EXPECT_THAT(read_file(plumbline.work() / "out/b/bench.md"), HasSubstr("it is never right"));
  const Answer words = plumbline({"bench", "b.yaml", "--out", "out/b"});
  EXPECT_THAT(words.out, HasSubstr("mood=never: 0 of 0 cells"));
  EXPECT_THAT(words.out, HasSubstr("solver=trial.unbuilt: 6 of 6 cells, 6 failed"));
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

TEST(Bench, AnyNumberOfWorkersAndAThrownAwayStoreGiveTheSameBits) {
  BenchProgram one, three, scratch;
  const std::string rest = "seeds: 1-20\nalternatives: {method: {a: {}, b: {solver.with.fails: 0.2}}}\n";
  for (const BenchProgram* program : {&one, &three}) program->bench_file(rest);
  scratch.bench_file(rest + "keep: results\n");
  one.run({"--workers", "1"});
  three.run({"--workers", "3"});
  scratch.run({"--workers", "2"});
  EXPECT_EQ(one.results().size(), 40u);
  // The reason of a failure names the pipeline's file, which lies elsewhere.
  const auto without_paths = [](std::map<std::string, std::string> results) {
    for (auto& [key, text] : results)
      if (const size_t at = text.find("\"error\""); at != std::string::npos) text.resize(at);
    return results;
  };
  EXPECT_EQ(without_paths(one.results()), without_paths(three.results()));
  EXPECT_EQ(without_paths(one.results()), without_paths(scratch.results()));
  EXPECT_FALSE(fs::exists(one.folder.path() / "store/tmp/plumbline-cells"));
  size_t solver_runs = 0;
  for (const auto& entry : fs::recursive_directory_iterator(scratch.folder.path() / "store/runs"))
    if (entry.is_regular_file() && contains(read_file(entry.path()), "trial.plain")) ++solver_runs;
  EXPECT_EQ(solver_runs, 0u);
}

TEST(Bench, StatusSaysHowFarItIsAndRunsNothing) {
  BenchProgram plumbline;
  plumbline.bench_file(two);
  Answer answer = plumbline({"bench", "b.yaml", "--status"});
  EXPECT_THAT(answer.out, HasSubstr("0 of 16 cells"));
  EXPECT_TRUE(plumbline.results().empty());
  plumbline.run({"--seeds", "1-3"});
  answer = plumbline({"bench", "b.yaml", "--status", "--out", "out/status"});
  EXPECT_THAT(answer.out, HasSubstr("6 of 16 cells"));
  EXPECT_EQ(answer.code, 1) << "not complete";
  EXPECT_THAT(read_file(plumbline.work() / "out/status/bench.md"), HasSubstr("10 not run yet"));
}

TEST(Bench, ASolverFromOutsideTakesPartByItsName) {
  BenchProgram plumbline(
      {PLUMBLINE_STORY_PLUGIN, PLUMBLINE_TRIAL_PLUGIN, PLUMBLINE_BENCH_PLUGIN, PLUMBLINE_OUTSIDE_PLUGIN});
  plumbline.bench_file("seeds: 1-8\nalternatives: {solver: [trial.plain, outside.solver]}\nrope: 0.01 mm\n");
  EXPECT_EQ(plumbline.run()["failed"], 0) << plumbline.answer.err;
  EXPECT_THAT(plumbline.summary()["verdicts"][0].get<std::string>(),
              HasSubstr("outside.solver and trial.plain gave the same in all 8 trials"));
  EXPECT_THAT(plumbline({"list"}).out, HasSubstr("outside.solver"));
  EXPECT_THAT(plumbline({"schema"}).out, HasSubstr("outside.solver"));
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

/// Of an archive alone nobody sees what it lacks, nor why a cell failed now that failed before.
TEST(Bench, AnArchiveSaysWhatItLacksAndVerifyWhatIsNotTheSame) {
  BenchProgram plumbline(
      {PLUMBLINE_STORY_PLUGIN, PLUMBLINE_TRIAL_PLUGIN, PLUMBLINE_BENCH_PLUGIN, PLUMBLINE_OUTSIDE_PLUGIN});
  plumbline.bench_file("seeds: 1-8\nalternatives: {solver: [trial.plain, outside.solver]}\n");
  plumbline.run({"--seeds", "1-3"});
  const Answer part = plumbline({"bench", "b.yaml", "--status", "--out", "out/s", "--archive", "part"});
  EXPECT_THAT(part.err, HasSubstr("part lacks 10 of 16 cells, which have not run"));
  EXPECT_THAT(plumbline({"bench", "verify", "part"}).out,
              HasSubstr("the bench has 16 cells: 10 had not run when it was archived"));
  // Without the plugin from outside its cells cannot be made again.
  const auto elsewhere = plumbline.folder.path() / "elsewhere";
  fs::create_directory(elsewhere);
  for (const std::string plugin : {PLUMBLINE_STORY_PLUGIN, PLUMBLINE_TRIAL_PLUGIN, PLUMBLINE_BENCH_PLUGIN})
    fs::create_symlink(plugin, elsewhere / fs::path(plugin).filename());
  fs::create_symlink(fs::path(PLUMBLINE_STORY_PLUGIN).parent_path() / "roles", elsewhere / "roles");
  plumbline.bench_file(
      "seeds: 1-3\nscenarios: {hard: {solver.with.fails: 1}}\nalternatives: {solver: [trial.plain, "
      "outside.solver]}\n");
  plumbline.run({"--archive", "whole"});
  plumbline.use_plugins(elsewhere);
  const Answer answer = plumbline({"bench", "verify", "whole", "--cells", "0"});
  EXPECT_EQ(answer.code, 1);
  EXPECT_THAT(answer.out, HasSubstr("6 of 6 archived cells made again, 3 agree to 1e-09, 3 differ"));
  EXPECT_THAT(answer.out, HasSubstr("solver=outside.solver, seed 1: it failed for another reason: "));
}

/// An archive of some of the file's scenarios is one of those: verify planned all, and was refused by the others.
TEST(Bench, AnArchiveOfOneScenarioIsVerifiedAsThat) {
  BenchProgram plumbline;
  plumbline.bench_file(
      "seeds: 1-3\nscenarios: {near: {}, far: {solver.with.factor: 2}}\nalternatives: {solver: [trial.plain]}\n");
  plumbline.run({"--scenario", "near", "solver.with.factor=3", "--archive", "near"});
  const Answer answer = plumbline({"bench", "verify", "near", "--cells", "0"});
  EXPECT_EQ(answer.code, 0) << answer.out << answer.err;
  EXPECT_THAT(answer.out, HasSubstr("3 of 3 archived cells made again, 3 agree"));
}

TEST(Bench, VerifyTellsCellsThatItCannotPlanAndInputsThatChanged) {
  BenchProgram plumbline;
  plumbline.bench_file("seeds: 1-3\nalternatives: {method: {a: {}, b: {solver.with.factor: 2}}}\n");
  plumbline.run({"--archive", "supplement"});
  // As an archive of a program that had more kinds of a role.
  const fs::path cells = plumbline.work() / "supplement/cells.jsonl",
                 file = plumbline.work() / "supplement/archive.json";
  std::string text = read_file(cells);
  for (size_t at; (at = text.find("method=b")) != std::string::npos;) text.replace(at, 8, "method=c");
  std::ofstream(cells) << text;
  Json archive = Json::parse(read_file(file));
  archive["cells_sha256"] = runtime::sha256_of(text.data(), text.size());
  archive["inputs"] = Json::array({{{"path", (plumbline.work() / "b.yaml").string()}, {"sha256", "00"}},
                                   {{"path", "/nowhere/at/all"}, {"sha256", "00"}}});
  std::ofstream(file) << archive.dump();
  const Answer answer = plumbline({"bench", "verify", "supplement", "--cells", "0"});
  EXPECT_EQ(answer.code, 1);
  EXPECT_THAT(answer.out, HasSubstr("differs: method=c, seed 1: it is archived, and no cell that this program makes"));
  EXPECT_THAT(answer.out, HasSubstr("b.yaml is not what the cells were made from: it has been changed"));
  EXPECT_THAT(answer.out, HasSubstr("differs: the input /nowhere/at/all is not there, and nothing"));
}

/// A disk under another name, a program in another folder: the bytes are the same, and so are the cells.
TEST(Bench, VerifyKnowsInputsAndProgramsByTheirBytes) {
  BenchProgram plumbline;
  const auto make = [&](const std::string& where, const std::string& content) {
    fs::create_directories(plumbline.work() / where / "data");
    plumbline.write(where + "/data/a.txt", content);
    plumbline.write(where + "/tell", "#!/bin/sh\n# " + content + "\nexit 3\n");
    fs::permissions(plumbline.work() / where / "tell", fs::perms::owner_all);
  };
  plumbline.bench_file("seeds: 1-2\n");
  for (const std::string from : {"story.length, with: {folder: ", "story.teller, with: {program: "}) {
    const std::string what = from.find("folder") != std::string::npos ? "data" : "tell";
    make("here", "a"), make("there", "a"), make("other", "b");
    plumbline.write("trial.yaml", "plumbline: 1\nvars: {seed: 1, place: none}\nnodes:\n  site: {use: " + from +
                                      "\"${place}\"}}\n  solver: {use: trial.plain, in: {site: site.number}}\n");
    const auto at = [&](const std::string& where) { return "place=" + (plumbline.work() / where / what).string(); };
    plumbline.run({at("here"), "--archive", "supplement"});
    fs::remove_all(plumbline.work() / "here");
    const Answer same = plumbline({"bench", "verify", "supplement", at("there")}),
                 other = plumbline({"bench", "verify", "supplement", at("other")});
    EXPECT_EQ(same.code, 0) << same.out << same.err;
    EXPECT_THAT(same.out, AllOf(HasSubstr("2 of 2 archived cells made again, 2 agree"), Not(HasSubstr("differs"))));
    EXPECT_EQ(other.code, 1) << other.out << other.err;
    EXPECT_THAT(other.out, HasSubstr("here/" + what +
                                     " is not there, and nothing that the cells are made from now has its bytes"));
  }
}

/// The last digit of what a reason rounds may fall to either side; what it counts may not.
TEST(Bench, VerifyTakesRoundedNumbersInReasonsForWhatTheyAre) {
  const auto failed = [](const std::string& reason) {
    return Json{{"status", "failed"}, {"failed_node", "solver"}, {"error", reason}, {"metrics", Json::object()}}.dump();
  };
  const auto differ = [&](const std::string& a, const std::string& b) {
    return !runtime::difference_of(failed(a), failed(b), 1e-9).empty();
  };
  EXPECT_FALSE(
      differ("may move by 0.012345 m (1 sigma), 2.34e+03 of 7", "may move by 0.012346 m (1 sigma), 2.35e+03 of 7"));
  EXPECT_FALSE(differ("w = -12.3", "w = -12.4"));
  EXPECT_TRUE(differ("w = -12.3", "w = 12.3"));
  EXPECT_TRUE(differ("may move by 0.012345 m", "may move by 0.012347 m"));
  EXPECT_TRUE(differ("2.34e+03 of 7", "2.34e+04 of 7"));
  EXPECT_TRUE(differ("3 of 16 points", "4 of 16 points"));
  EXPECT_TRUE(differ("point 3.1 of F1", "point 3.1 of F2"));
}

/// Once `--archive .` removed the folder "files" that stood there.
TEST(Bench, AnArchiveReplacesNothingButAnArchive) {
  BenchProgram plumbline;
  plumbline.bench_file("seeds: 1-2\n");
  fs::create_directories(plumbline.work() / "mine/files");
  plumbline.write("mine/files/thesis.txt", "years of work\n");
  const Answer answer = plumbline({"bench", "b.yaml", "--archive", "mine"});
  EXPECT_NE(answer.code, 0);
  EXPECT_THAT(answer.err, HasSubstr("mine is there and no archive of a bench"));
  EXPECT_TRUE(fs::exists(plumbline.work() / "mine/files/thesis.txt"));
  EXPECT_TRUE(plumbline.results().empty()) << "said before anything runs";
  for (int k = 0; k < 2; ++k) EXPECT_EQ(plumbline({"bench", "b.yaml", "--archive", "own"}).code, 0) << k;
}

TEST(Bench, AnArchiveMakesItsCellsAgainAndNoticesWhatWasChanged) {
  BenchProgram plumbline;
  plumbline.bench_file("seeds: 1-8\nalternatives: {method: {a: {}, weak: {solver.with.fails: 0.5}}}\n");
  plumbline.run({"--archive", "supplement"});
  fs::rename(plumbline.work() / "b.yaml", plumbline.work() / "gone.yaml");
  fs::rename(plumbline.work() / "trial.yaml", plumbline.work() / "gone too.yaml");
  Answer answer = plumbline({"bench", "verify", "supplement", "--cells", "0"});
  EXPECT_EQ(answer.code, 0) << answer.err;
  EXPECT_THAT(answer.out, HasSubstr("16 of 16 archived cells made again, 16 agree to 1e-09, 0 differ"));
  EXPECT_THAT(plumbline({"bench", "verify", "supplement", "--cells", "5"}).out, HasSubstr("5 of 16 archived cells"));
  const Json archive = Json::parse(read_file(plumbline.work() / "supplement/archive.json"));
  for (const char* part : {"commit", "compiler", "libraries", "plugins"})
    EXPECT_TRUE(archive["machine"].contains(part)) << part;
  // Another pipeline than the one that was archived.
  std::ofstream(plumbline.work() / "supplement/files/trial.yaml", std::ios::app) << "# changed\n";
  answer = plumbline({"bench", "verify", "supplement"});
  EXPECT_NE(answer.code, 0);
  EXPECT_THAT(answer.err, HasSubstr("files/trial.yaml is not what was archived"));
}

TEST(Bench, ARunThatWasCutOffGoesOnWhereItWas) {
  BenchProgram plumbline;
  plumbline.bench_file("seeds: 1-20\nalternatives: {method: {a: {solver.with.milliseconds: 50}}}\n");
  const pid_t process = plumbline.start({"bench", "b.yaml", "--workers", "1", "--out", "out/b"});
  while (plumbline.results().size() < 3) usleep(5000);
  kill(process, SIGTERM);
  EXPECT_EQ(plumbline.finish(process).code, 130);
  const size_t done = plumbline.results().size();
  EXPECT_LT(done, 20u);
  EXPECT_EQ(plumbline.run()["found"], done);
  EXPECT_EQ(plumbline.results().size(), 20u);
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

}  // namespace test_bench
}  // namespace plumbline::test

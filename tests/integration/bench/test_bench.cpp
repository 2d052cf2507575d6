// plumbline bench from outside: what is shared runs once, what failed is told every time, the order never matters.
#include "bench_program.hpp"

namespace plumbline::test {
namespace test_bench {

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

/// What ran in the other scenarios says nothing of it.
/// One without control is made to fail: its bench is complete, and ended with 1 for ever.
TEST(Bench, AScenarioOfWhichAllCellsRanAndFailedIsToldAndNoError) {
  BenchProgram plumbline;
  plumbline.bench_file(
      "seeds: 1-4\nscenarios: {ground: {}, tower: {solver.with.fails: 1}}\n"
      "alternatives: {method: {one: {}, two: {}}}\n");
  plumbline.run({"-q"});
  EXPECT_EQ(plumbline.answer.code, 0) << plumbline.answer.err;
  EXPECT_THAT(plumbline.answer.err, HasSubstr("scenario=tower gave no result: all its 8 cells failed, the first: "));
  EXPECT_THAT(plumbline.answer.err, Not(HasSubstr("ground")));
}

TEST(Bench, AScenarioThatCannotRunWasNotMeasured) {
  BenchProgram plumbline;
  plumbline.write("odd.yaml", "plumbline: 1\nvars: {seed: 1, factor: 1}\nnodes:\n  site: {use: story.draw}\n");
  plumbline.bench_file("seeds: 1-4\nscenarios: {ground: {}, tower: {pipeline: odd.yaml}}\n");
  plumbline.run({"-q"});
  EXPECT_EQ(plumbline.answer.code, 1);
  EXPECT_THAT(plumbline.answer.err, HasSubstr("scenario=tower gave no result: all cells failed"));
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
  plumbline.write("odd.yaml", "plumbline: 1\nvars: {seed: 1, factor: 1}\nnodes:\n  site: {use: story.draw}\n");
  plumbline.bench_file(
      "seeds: 1-3\nmatrix: {factor: [1, 2]}\n"
      "alternatives: {method: {plain: {}, odd: {pipeline: odd.yaml}}, mood: {calm: {}, never: {solver.with.own: 1}}}\n"
      "exclude: [{mood: never, why: it is never right}]\n");
  plumbline.run();
  const Json summary = plumbline.summary();
  ASSERT_EQ(summary["unused"].size(), 2u);
  for (const Json& verdict : summary["verdicts"])
    EXPECT_THAT(verdict.get<std::string>(), Not(HasSubstr("odd"))) << "said once, not against everybody";
  EXPECT_THAT(summary["unused"][0].get<std::string>(), HasSubstr("method=odd gave no result: it did not run, bec"));
  EXPECT_THAT(summary["unused"][1].get<std::string>(), HasSubstr("mood=never gave no result: all its cells are excl"));
  EXPECT_THAT(read_file(plumbline.work() / "out/b/bench.md"), HasSubstr("it is never right"));
  const Answer words = plumbline({"bench", "b.yaml", "--out", "out/b"});
  EXPECT_THAT(words.out, HasSubstr("mood=never: 0 of 0 cells"));
  EXPECT_THAT(words.out, HasSubstr("method=odd: 6 of 6 cells, 6 failed"));
  EXPECT_THAT(summary["choices"][0].get<std::string>(), HasSubstr("nothing to choose: only plain ran"));
}

/// As KEY=VALUE with such a kind is. Once its cells failed one by one, and the other one was "beaten nowhere".
TEST(Bench, AKindInAListThatNoPluginBringsIsRefused) {
  BenchProgram plumbline;
  plumbline.bench_file("seeds: 1-3\nalternatives: {solver: [trial.plain, trial.plian]}\n");
  const Answer answer = plumbline({"bench", "b.yaml"});
  EXPECT_EQ(answer.code, 2);
  EXPECT_THAT(answer.err, HasSubstr("b.yaml:5:24: "));
  EXPECT_THAT(answer.err, HasSubstr("no plugin brings the kind 'trial.plian' — did you mean 'trial.plain'?"));
  EXPECT_TRUE(plumbline.results().empty());
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

}  // namespace test_bench
}  // namespace plumbline::test

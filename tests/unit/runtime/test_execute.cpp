// What comes out of a run, and what becomes of nodes that misbehave.
#include <thread>

#include "runtime/base/told_once.hpp"
#include "story.hpp"

namespace plumbline::test {
namespace test_execute {

const std::string wide =
    "s: {use: story.series, with: {values: [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16]}}\n"
    "q: {use: story.square, in: {number: s.numbers}}\n"
    "n: {use: story.draw_each, in: {number: q.square}}\n"
    "t: {use: story.sum, in: {numbers: n.number}}\n"
    "u: {use: story.sum, in: {numbers: q.square}}\n"
    "v: {use: story.add, in: {a: t.sum, b: u.sum}}";

TEST(Execute, SameBitsWithAnyNumberOfThreads) {
  std::vector<std::map<std::string, runtime::Hashes>> first;
  for (const int threads : {1, 2, 8}) {
    Story story(wide);
    ASSERT_TRUE(story.run({}, threads).ok());
    std::vector<std::map<std::string, runtime::Hashes>> outputs;
    for (const auto& node : story.result.nodes) outputs.push_back(node.outputs);
    if (first.empty()) first = outputs;
    EXPECT_EQ(outputs, first) << threads << " threads";
  }
}

TEST(Execute, AFailureEndsItsBranchOnly) {
  Story story("x: {use: story.throws}\ny: {use: story.add, in: {a: x.number}}\nz: {use: story.add, in: {a: y.sum}}\n" +
              small_chain);
  story.run();
  EXPECT_EQ(story.status("x"), "failed");
  EXPECT_EQ(story.with_status(runtime::NodeStatus::skipped), "y z");
  EXPECT_EQ(story.executed(), "a b c d");
  EXPECT_FALSE(story.result.ok());
  EXPECT_FALSE(story.result.cancelled);
  EXPECT_EQ(story.node("x").error,
            story.pipeline().string() + ":4:3: node 'x' (story.throws) failed: the bridge is out");
  EXPECT_EQ(story.node("y").error, "its input 'a' comes from 'x', which failed");
  EXPECT_EQ(story.node("z").error, "its input 'a' comes from 'y', which did not run because 'x' failed");
  EXPECT_EQ(story.node("y").cause + story.node("z").cause, "xx");
}

TEST(Execute, AFailedItemIsNamedAndTheOthersAreKept) {
  Story story(
      "s: {use: story.series, with: {values: [1, -2, 3, -4]}}\nq: {use: story.square, in: {number: s.numbers}}");
  story.run();
  const std::string& error = story.node("q").error;
  EXPECT_NE(error.find("node 'q' (story.square) failed on item 2 of 4: cannot square -2"), std::string::npos) << error;
  EXPECT_NE(error.find("on item 4 of 4"), std::string::npos) << error;
  story.run({"s.with.values=[1, 2, 3, 4]"});
  EXPECT_EQ(story.node("q").items_executed, 2u) << "1 and 3 were done before";
}

TEST(Execute, WhatAllItemsFailWithIsSaidOnce) {
  Story story(
      "s: {use: story.series, with: {values: [-2, 3, -2, -2]}}\nq: {use: story.square, in: {number: s.numbers}}");
  story.run();
  const std::string& error = story.node("q").error;
  EXPECT_NE(error.find("failed on item 1 of 4 (and 2 others alike): cannot square -2"), std::string::npos) << error;
  EXPECT_EQ(error.find('\n'), std::string::npos) << error;
}

TEST(ToldOnce, WarningsThatDifferInNamesAndNumbersAreCounted) {
  std::vector<std::string> texts;
  for (int i = 1; i <= 9; ++i) {
    const std::string name = "folder/IMG " + std::to_string(i) + ".jpg";
    texts.push_back(name + ": the tags measure 0." + std::to_string(50 + i) +
                    " of their spacing, 0.838 is in b.yaml on item " + std::to_string(i) + " of 9");
    texts.push_back("left out: " + name + ": is the same file as " + name + " on item " + std::to_string(i) + " of 9");
    if (i < 4) texts.push_back(name + ": is blurred on item " + std::to_string(i) + " of 9");
  }
  const std::vector<std::string> lines = runtime::told_once(texts);
  ASSERT_EQ(lines.size(), 5u) << "three of a kind are each said";
  EXPECT_EQ(lines[0],
            "folder/IMG 1.jpg: the tags measure 0.51 of their spacing, 0.838 is in b.yaml [and 8 more like this: "
            "folder/IMG 2.jpg, folder/IMG 3.jpg, folder/IMG 4.jpg, folder/IMG 5.jpg, others; run.jsonl has each]");
  EXPECT_EQ(lines[1].rfind("left out: folder/IMG 1.jpg: is the same file", 0), 0u) << lines[1];
  EXPECT_NE(lines[1].find("[and 8 more like this: folder/IMG 2.jpg"), std::string::npos) << lines[1];
  EXPECT_EQ(lines[2], texts[2]);
}

TEST(Execute, ItemsOfOneThreadAddUpToLessThanTheTimeOnTheClock) {
  Story story("s: {use: story.series, with: {values: [1, 2, 3, 4]}}\nq: {use: story.square, in: {number: s.numbers}}");
  ASSERT_TRUE(story.run({}, 1).ok());
  EXPECT_GT(story.node("q").item_seconds, 0);
  EXPECT_LE(story.node("q").item_seconds, story.node("q").seconds + 1e-9);
  ASSERT_TRUE(story.run({}, 1).ok());
  EXPECT_EQ(story.node("q").seconds, 0) << "nothing ran";
  EXPECT_EQ(story.node("q").item_seconds, 0);
}

TEST(Execute, AnEmptyListIsNoError) {
  Story story(
      "s: {use: story.series, with: {values: []}}\nq: {use: story.square, in: {number: s.numbers}}\n"
      "t: {use: story.sum, in: {numbers: q.square}}");
  ASSERT_TRUE(story.run().ok());
  EXPECT_EQ(story.node("q").items, 0u);
  EXPECT_EQ(story.value("t", "sum"), 0);
}

TEST(Execute, AMissingOutputIsAnError) {
  Story story("x: {use: story.forgets}");
  story.run();
  EXPECT_NE(story.node("x").error.find("ended without committing its output 'number'"), std::string::npos)
      << story.node("x").error;
}

TEST(Execute, BytesThatAreNoArtifactAreRefused) {
  Story story("x: {use: story.garbage}");
  story.run();
  EXPECT_NE(story.node("x").error.find("output 'number' is no valid plumbline.Number/1"), std::string::npos)
      << story.node("x").error;
}

TEST(Execute, AnOutputIsCommittedOnce) {
  Story story("x: {use: story.twice}");
  story.run();
  EXPECT_NE(story.node("x").error.find("output 'number' was committed twice"), std::string::npos)
      << story.node("x").error;
}

TEST(Execute, TheSeedComesBeforeTheFolder) {
  Story story("x: {use: story.late_seed}");
  story.run();
  EXPECT_NE(story.node("x").error.find("asked for its seed after make_folder()"), std::string::npos)
      << story.node("x").error;
}

TEST(Execute, AFolderIsWholeOrAbsent) {
  Story story("w: {use: story.folder, with: {fail: true}}");
  story.run();
  EXPECT_EQ(story.status("w"), "failed");
  EXPECT_TRUE(std::filesystem::is_empty(story.folder.path() / "store" / "folders"));
  EXPECT_TRUE(std::filesystem::is_empty(story.folder.path() / "store" / "tmp"));
}

TEST(Execute, WarningsAndMetricsAreKeptWithTheResult) {
  Story story(
      "s: {use: story.series, with: {values: [1, 200]}}\nq: {use: story.square, in: {number: s.numbers}}\n"
      "c: {use: story.constant}\nm: {use: story.add, in: {a: c.number}}");
  for (int i = 0; i < 2; ++i) {
    story.run();
    EXPECT_EQ(story.node("q").warnings, std::vector<std::string>{"a large number on item 2 of 2"});
    ASSERT_EQ(story.node("m").metrics.size(), 1u);
    EXPECT_EQ(story.node("m").metrics[0].name, "sum");
    EXPECT_EQ(story.node("m").metrics[0].value, 1);
  }
}

TEST(Execute, MemoryIsSharedOut) {
  const std::string nodes =
      "s: {use: story.series, with: {values: [40, 40, 40, 40, 40, 40, 40, 40]}}\n"
      "h: {use: story.hungry, in: {mebibytes: s.numbers}}";
  Story story(nodes);
  ASSERT_TRUE(story.run({}, 4, uint64_t{100} << 20).ok());
  for (const double most : story.values("h", "most")) EXPECT_LE(most, 2);
}

TEST(Execute, ARequestAboveTheLimitRunsAlone) {
  Story story(
      "s: {use: story.series, with: {values: [500, 500, 500]}}\nh: {use: story.hungry, in: {mebibytes: s.numbers}}");
  ASSERT_TRUE(story.run({}, 3, uint64_t{100} << 20).ok());
  ASSERT_EQ(story.node("h").warnings.size(), 3u) << "and says so";
  EXPECT_NE(story.node("h").warnings[0].find("it takes 500 MiB of memory by its own account, and the limit"),
            std::string::npos)
      << story.node("h").warnings[0];
  ASSERT_TRUE(story.run({}, 3, uint64_t{600} << 20).ok());
  EXPECT_TRUE(story.node("h").warnings.empty()) << "it is of one machine, so it is not stored";
}

/// Once --memory 100MiB let a block of 596 MiB pass without a word.
TEST(Execute, ALimitThatSomebodySetIsKept) {
  Story story("s: {use: story.series, with: {values: [500]}}\nh: {use: story.hungry, in: {mebibytes: s.numbers}}");
  story.keep_memory = true;
  ASSERT_FALSE(story.run({}, 3, uint64_t{100} << 20).ok());
  EXPECT_NE(story.node("h").error.find(
                "it takes 500 MiB of memory by its own account, and --memory allows 100 MiB: raise it"),
            std::string::npos)
      << story.node("h").error;
  EXPECT_TRUE(story.run({}, 3, uint64_t{600} << 20).ok());
}

TEST(Execute, TwoProgramsShareOneStore) {
  Story story(wide);
  const auto graph = load_pipeline(story.pipeline(), {}, story_registry());
  std::vector<runtime::RunResult> results(2);
  std::vector<std::thread> programs;
  for (auto& result : results)
    programs.emplace_back([&] {
      runtime::Store store(story.folder.path() / "store");
      runtime::Observer silent;
      result = execute(graph, story_registry(), store, {2, 0, nullptr}, silent);
    });
  for (auto& program : programs) program.join();
  ASSERT_TRUE(results[0].ok() && results[1].ok());
  for (size_t i = 0; i < graph.nodes.size(); ++i) EXPECT_EQ(results[0].nodes[i].outputs, results[1].nodes[i].outputs);
  story.run();
  EXPECT_EQ(story.executed(), "");
}

TEST(Link, AnOverrideThatBreaksTheGraphIsNamedFirst) {
  std::string nodes = "a: {use: story.constant}\nb: {use: story.add, in: {a: a.number}}";
  for (int n = 0; n < 9; ++n) nodes += "\nn" + std::to_string(n) + ": {use: story.add, in: {a: b.sum}}";
  Story story(nodes);
  story.plan();
  try {
    story.plan({"seed=3", "b.use=story.folder", "n1.with.offset=2"});
    FAIL();
  } catch (const runtime::InvalidPipeline& error) {
    const std::string text = error.what();
    EXPECT_EQ(text.rfind("'b.use=story.folder': without it the pipeline is valid, with it these things do not fit, and "
                         "7 more that follow from them:\n",
                         0),
              0u)
        << text;
    EXPECT_EQ(error.problems().size(), 4u);
  }
  try {  // what is wrong with the override itself needs no other words
    story.plan({"b.use=story.ad"});
    FAIL();
  } catch (const runtime::InvalidPipeline& error) {
    EXPECT_NE(std::string(error.what()).find("'b.use=story.ad': there is no node 'story.ad'"), std::string::npos);
    EXPECT_EQ(std::string(error.what()).find("without it"), std::string::npos) << error.what();
  }
}

TEST(Link, SixtyThousandNodesInARow) {
  // The last one first, so that following the connections goes as deep as it can.
  std::string nodes;
  for (int n = 60000; n-- > 1;)
    nodes += "n" + std::to_string(n) + ": {use: story.add, in: {a: n" + std::to_string(n - 1) +
             (n == 1 ? ".number}}\n" : ".sum}}\n");
  Story story("");
  std::ofstream(story.pipeline()) << "plumbline: 1\nnodes:\n";
  std::ofstream stream(story.pipeline(), std::ios::app);
  std::istringstream lines(nodes + "n0: {use: story.constant}\n");
  for (std::string line; std::getline(lines, line);) stream << "  " << line << "\n";
  stream.close();
  const auto graph = load_pipeline(story.pipeline(), {}, story_registry());
  ASSERT_EQ(graph.nodes.size(), 60000u);
  EXPECT_EQ(graph.nodes.front().name, "n0");
  EXPECT_EQ(graph.nodes.back().name, "n59999");
}

/// Programs that start this one ask of what kind a failure is, and read no sentences for it.
TEST(Execute, AFailureHasAKind) {
  const std::pair<const char*, plumbline_answer> kinds[] = {
      {"plain", PLUMBLINE_FAILED}, {"bad_input", PLUMBLINE_BAD_INPUT}, {"not_converged", PLUMBLINE_NOT_CONVERGED}};
  for (const auto& [how, kind] : kinds) {
    Story story(std::string("a: {use: story.throws, with: {how: ") + how + "}}\nb: {use: story.constant}\n");
    const auto& result = story.run();
    EXPECT_EQ(story.node("a").failure, kind) << how;
    EXPECT_EQ(story.node("b").failure, PLUMBLINE_DONE);
    EXPECT_EQ(result.not_converged(), kind == PLUMBLINE_NOT_CONVERGED) << how;
  }
  Story both("a: {use: story.throws, with: {how: not_converged}}\nb: {use: story.throws}\n");
  EXPECT_FALSE(both.run().not_converged()) << "the other one needs another mend";
}

}  // namespace test_execute
}  // namespace plumbline::test

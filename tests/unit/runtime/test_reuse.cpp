// What runs again after which change.
#include "story.hpp"

namespace plumbline::test {
namespace test_reuse {

TEST(Reuse, SecondRunExecutesNothing) {
  Story story(small_chain);
  story.run();
  EXPECT_EQ(story.executed(), "a b c d");
  EXPECT_EQ(story.value("c", "sum"), 14);
  story.run();
  EXPECT_EQ(story.executed(), "");
  EXPECT_EQ(story.with_status(runtime::NodeStatus::reused), "a b c d");
  EXPECT_EQ(story.value("c", "sum"), 14);
}

TEST(Reuse, AChangedParameterRunsItsNodeAndWhatFollows) {
  Story story(small_chain);
  story.run();
  story.run({"b.with.offset=2"});
  EXPECT_EQ(story.executed(), "b c");
  EXPECT_EQ(story.value("c", "sum"), 15);
  story.run({"c.with.offset=20"});
  EXPECT_EQ(story.executed(), "c") << "the store still has b as it was before";
}

TEST(Reuse, EqualOutputsStopTheChange) {
  Story story(small_chain);
  story.run();
  story.run({"a.with.value=2", "b.with.offset=2"});
  EXPECT_EQ(story.executed(), "a b") << "b gives 4 as before, so c need not run";
}

TEST(Reuse, NamesAndOrderInTheFileDoNotCount) {
  Story story("x: {use: story.constant, with: {value: 3}}\ny: {use: story.add, in: {a: x.number}}");
  story.run();
  story.tell("second: {use: story.add, in: {a: first.number}}\nfirst: {use: story.constant, with: {value: 3}}");
  story.run();
  EXPECT_EQ(story.executed(), "");
}

TEST(Reuse, ANewItemRunsOnlyThatItem) {
  Story story(
      "s: {use: story.series, with: {values: [1, 2, 3]}}\nq: {use: story.square, in: {number: s.numbers}}\n"
      "t: {use: story.sum, in: {numbers: q.square}}");
  story.run();
  EXPECT_EQ(story.node("q").items, 3u);
  EXPECT_EQ(story.node("q").items_executed, 3u);
  story.run({"s.with.values=[1, 7, 2, 3]"});
  EXPECT_EQ(story.executed(), "s q t");
  EXPECT_EQ(story.node("q").items, 4u);
  EXPECT_EQ(story.node("q").items_executed, 1u);
  EXPECT_EQ(story.values("q", "square"), (std::vector<double>{1, 49, 4, 9}));
}

TEST(Reuse, TheSeedRunsOnlyWhatDraws) {
  Story story("d: {use: story.draw}\ne: {use: story.add, in: {a: d.number}}\nf: {use: story.constant}");
  story.run();
  const double first = story.value("d", "number");
  story.run({"seed=2"});
  EXPECT_EQ(story.executed(), "d e");
  EXPECT_NE(story.value("d", "number"), first);
  story.run({"seed=1"});
  EXPECT_EQ(story.executed(), "");
  EXPECT_EQ(story.value("d", "number"), first);
}

TEST(Reuse, NodesAndItemsDrawDifferentNumbers) {
  Story story(
      "d: {use: story.draw}\ne: {use: story.draw}\ns: {use: story.series, with: {values: [0, 0]}}\n"
      "i: {use: story.draw_each, in: {number: s.numbers}}");
  story.run();
  EXPECT_NE(story.value("d", "number"), story.value("e", "number"));
  const auto items = story.values("i", "number");
  EXPECT_NE(items.at(0), items.at(1));
}

TEST(Reuse, ANonDeterministicNodeAlwaysRuns) {
  Story story("n: {use: story.clock}\nm: {use: story.add, in: {a: n.number}}");
  story.run();
  story.run();
  EXPECT_EQ(story.executed(), "n m");
}

TEST(Reuse, AFailureIsNotKept) {
  Story story("t: {use: story.throws}");
  story.run();
  story.run();
  EXPECT_EQ(story.status("t"), "failed");
}

TEST(Reuse, ADamagedBlobIsNamedAndItsNodeRunsAgain) {
  Story story(small_chain);
  story.run();
  story.move_contents_to_blobs();
  const std::string hash = story.node("b").outputs.at("sum").at(0);
  {
    std::fstream blob(story.blob(hash), std::ios::in | std::ios::out | std::ios::binary);
    blob.seekp(-1, std::ios::end);
    blob.put('\x55');
  }
  story.run();
  EXPECT_EQ(story.executed(), "b");
  ASSERT_EQ(story.node("b").warnings.size(), 1u);
  EXPECT_NE(story.node("b").warnings[0].find(hash), std::string::npos) << story.node("b").warnings[0];
  EXPECT_EQ(story.value("c", "sum"), 14);
  story.run();
  EXPECT_EQ(story.executed(), "");
}

TEST(Reuse, AnEmptiedOrMissingBlobIsMadeAgain) {
  Story story(small_chain);
  story.run();
  story.move_contents_to_blobs();
  std::filesystem::resize_file(story.blob(story.node("a").outputs.at("number").at(0)), 0);
  std::filesystem::remove(story.blob(story.node("d").outputs.at("number").at(0)));
  story.run();
  EXPECT_EQ(story.executed(), "a d");
  EXPECT_TRUE(story.result.ok());
}

/// Small outputs are in the run's record: a record in which one was changed is not believed.
TEST(Reuse, ADamagedContentIsNamedAndItsNodeRunsAgain) {
  Story story(small_chain);
  story.run();
  const std::string hash = story.node("b").outputs.at("sum").at(0);
  ASSERT_FALSE(std::filesystem::exists(story.blob(hash)));
  for (const auto& file : story.records()) {
    auto record = stored_record(file);
    if (!record.at("contents").contains(hash)) continue;
    std::string hex = record["contents"][hash];
    hex.back() = hex.back() == '0' ? '1' : '0';
    record["contents"][hash] = hex;
    store_record(file, record);
  }
  story.run();
  EXPECT_EQ(story.executed(), "b");
  ASSERT_EQ(story.node("b").warnings.size(), 1u);
  EXPECT_NE(story.node("b").warnings[0].find(hash), std::string::npos) << story.node("b").warnings[0];
  EXPECT_EQ(story.value("c", "sum"), 14);
  story.run();
  EXPECT_EQ(story.executed(), "");
}

TEST(Reuse, ARecordWithoutContentsIsBelievedIfTheBlobsAreThere) {
  Story story(small_chain);
  story.run();
  story.move_contents_to_blobs();
  story.run();
  EXPECT_EQ(story.executed(), "");
  EXPECT_EQ(story.value("c", "sum"), 14);
}

/// It has no record; what it gave must be found all the same by who has the hash.
TEST(Reuse, WhatANodeWithoutRecordGaveIsABlob) {
  Story story("n: {use: story.clock}");
  story.run();
  EXPECT_TRUE(std::filesystem::exists(story.blob(story.node("n").outputs.at("number").at(0))));
}

TEST(Reuse, ADamagedRecordIsPassedOver) {
  Story story(small_chain);
  story.run();
  for (const auto& entry : std::filesystem::recursive_directory_iterator(story.folder.path() / "store" / "runs"))
    if (entry.is_regular_file()) std::ofstream(entry.path(), std::ios::trunc) << "{\"kind\": ";
  story.run();
  EXPECT_EQ(story.executed(), "a b c d");
  EXPECT_TRUE(story.result.ok());
}

/// A metric stands in the record alone: no hash of a blob tells that it was changed.
TEST(Reuse, ARecordInWhichAMetricChangedIsNotBelieved) {
  Story story(small_chain);
  story.run();
  for (const auto& file : story.records()) {
    std::string text = read_file(file);
    const size_t metric = text.find("\"value\":4");
    if (metric == std::string::npos) continue;
    text[metric + 8] = '5';
    std::ofstream(file, std::ios::trunc) << text;
  }
  story.run();
  EXPECT_EQ(story.executed(), "b");
  EXPECT_EQ(story.node("b").metrics.at(0).value, 4);
  ASSERT_EQ(story.node("b").warnings.size(), 1u);
  EXPECT_NE(story.node("b").warnings[0].find("its record in the store is damaged"), std::string::npos);
}

/// What a tool that copies or renames files gets wrong.
TEST(Reuse, ARecordUnderTheKeyOfAnotherNodeIsNotBelieved) {
  Story story("a: {use: story.constant, with: {value: 1}}\nb: {use: story.constant, with: {value: 2}}\n");
  story.run();
  const auto record_of = [&](const std::string& node) {
    const std::string key = story.node(node).keys.at(0);
    return story.folder.path() / "store/runs" / key.substr(0, 2) / (key + ".json");
  };
  std::filesystem::copy_file(record_of("a"), record_of("b"), std::filesystem::copy_options::overwrite_existing);
  story.run();
  EXPECT_EQ(story.executed(), "b");
  EXPECT_EQ(story.value("b", "number"), 2);
}

/// A later program may say in a record what this one does not understand, such as that the result must not be taken.
TEST(Reuse, RecordsOfAnotherFormatAreComputedAgainWithoutAWord) {
  Story story(small_chain);
  story.run();
  for (const auto& file : story.records()) {
    auto record = stored_record(file);
    record["format"] = 2;
    store_record(file, record);
  }
  story.run();
  EXPECT_EQ(story.executed(), "a b c d");
  for (const auto& node : story.result.nodes) EXPECT_TRUE(node.warnings.empty()) << node.warnings[0];
}

TEST(Reuse, AFolderThatWasChangedIsMadeAgain) {
  Story story("w: {use: story.folder}\nr: {use: story.read, in: {folder: w.folder}}");
  story.run();
  EXPECT_EQ(story.value("r", "number"), 5);
  story.run();
  EXPECT_EQ(story.executed(), "");
  for (const auto& entry : std::filesystem::directory_iterator(story.folder.path() / "store" / "folders"))
    std::ofstream(entry.path() / "a.txt") << "changed by a stranger";
  story.run();
  EXPECT_EQ(story.executed(), "w");
  EXPECT_EQ(story.node("w").warnings.size(), 1u);
  for (const auto& entry : std::filesystem::directory_iterator(story.folder.path() / "store" / "folders"))
    EXPECT_EQ(read_file(entry.path() / "a.txt"), "hello");
}

}  // namespace test_reuse
}  // namespace plumbline::test

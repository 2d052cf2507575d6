// Several connections of one input.
#include "story.hpp"

namespace plumbline::test {
namespace test_edges {

double value_of(Story& story, const std::string& node, const std::string& port) {
  const std::string hash = story.node(node).outputs.at(port).at(0);
  const auto blob = story.store->get(hash);
  return flatbuffers::GetRoot<Number>(blob.bytes().data)->value();
}

const std::string two_series =
    "a: {use: story.series, with: {values: [1, 2]}}\nb: {use: story.constant, with: {value: 5}}\n";

TEST(Edges, AListTakesSeveralInTheirOrder) {
  Story story(two_series +
              "t: {use: story.sum, in: {numbers: [a.numbers, b.number]}}\n"
              "u: {use: story.sum, in: {numbers: [b.number, a.numbers]}}");
  ASSERT_TRUE(story.run().ok());
  EXPECT_EQ(value_of(story, "t", "sum"), 1 * 1 + 2 * 2 + 3 * 5);
  EXPECT_EQ(value_of(story, "u", "sum"), 1 * 5 + 2 * 1 + 3 * 2);
  story.run({"t.in.numbers=[b.number, a.numbers]"});
  EXPECT_EQ(value_of(story, "t", "sum"), 13);
}

TEST(Edges, ANodeThatRunsForEachItemTakesThemAll) {
  Story story(two_series + "q: {use: story.square, in: {number: [a.numbers, b.number]}}");
  ASSERT_TRUE(story.run().ok());
  EXPECT_EQ(story.node("q").items, 3u);
}

TEST(Edges, WhatTakesOneIsRefusedSeveral) {
  Story story(two_series + "s: {use: story.add, in: {a: [b.number, b.number]}}");
  try {
    story.run();
    FAIL();
  } catch (const runtime::InvalidPipeline& error) {
    EXPECT_NE(std::string(error.what()).find("input 'a' of 's' takes one connection, found several"), std::string::npos)
        << error.what();
  }
}

TEST(Edges, ARecordNamesAllOfThem) {
  Story story(two_series + "t: {use: story.sum, in: {numbers: [a.numbers, b.number]}}");
  story.run();
  size_t at = 0;
  while (story.graph.nodes[at].name != "t") ++at;
  const std::string line = runtime::Record::node_line(story.graph.nodes[at], story.result.nodes[at], true);
  EXPECT_EQ(nlohmann::json::parse(line)["connections"]["numbers"], "a.numbers, b.number");
}

}  // namespace test_edges
}  // namespace plumbline::test

// `for_each`: nodes that stand for each kind of a role, and `each`: a node that takes one item, for each of a list.
#include "story.hpp"

namespace plumbline::test {
namespace test_role_expansion {

double value_of(Story& story, const std::string& node, const std::string& port) {
  const std::string hash = story.node(node).outputs.at(port).at(0);
  const auto blob = story.store->get(hash);
  return flatbuffers::GetRoot<Number>(blob.bytes().data)->value();
}

std::string refusal(const std::string& nodes, const std::vector<std::string>& overrides = {}) {
  Story story(nodes);
  try {
    story.run(overrides);
  } catch (const runtime::InvalidPipeline& error) {
    return error.what();
  }
  return "";
}

TEST(RoleExpansion, ANodeStandsForEachKindOfTheRoleAndWhatFollowsTakesThemAll) {
  Story story(
      "s: {for_each: source.value, use: \"${kind}\"}\n"
      "again: {for_each: source.value, use: story.add, in: {a: s.number}, with: {offset: \"${kind.value}\"}}\n"
      "t: {use: story.sum, in: {numbers: again.sum}}\n");
  ASSERT_TRUE(story.run().ok());
  // story.constant is the one kind of the role with the parameter: 1, and its default 1 added.
  EXPECT_EQ(value_of(story, "again_story_constant", "sum"), 2);
  EXPECT_EQ(value_of(story, "t", "sum"), 2);
  story.run({"s_story_constant.with.value=5"});
  EXPECT_EQ(value_of(story, "t", "sum"), 6);
}

TEST(RoleExpansion, WithoutAKindWhatWouldTakeFromItFallsAway) {
  Story story(
      "s: {for_each: source.nothing_has_this, use: \"${kind}\"}\n"
      "t: {use: story.sum, in: {numbers: s.number}}\n"
      "c: {use: story.constant, with: {value: 3}}\n"
      "u: {use: story.add, in: {a: c.number, b: t.sum}}\n");
  ASSERT_TRUE(story.run().ok());
  EXPECT_EQ(value_of(story, "u", "sum"), 3);
  EXPECT_EQ(story.graph.nodes.size(), 2u);
}

/// A node for each kind of its own that takes from one of which there are none: its copies fall away like any other.
TEST(RoleExpansion, CopiesThatHaveNothingToTakeFallAwayToo) {
  Story story(
      "s: {for_each: source.nothing_has_this, use: \"${kind}\"}\n"
      "t: {for_each: source.value, use: story.sum, in: {numbers: s.number}}\n"
      "c: {use: story.constant, with: {value: 3}}\n"
      "u: {use: story.add, in: {a: c.number, b: t.sum}}\n");
  ASSERT_TRUE(story.run().ok());
  EXPECT_EQ(value_of(story, "u", "sum"), 3);
  EXPECT_EQ(story.graph.nodes.size(), 2u);
}

TEST(RoleExpansion, WhatNeedsItSaysSo) {
  EXPECT_NE(refusal("s: {for_each: source.nothing_has_this, use: \"${kind}\"}\n"
                    "t: {use: story.sum, in: {numbers: s.number}}\n"
                    "u: {use: story.add, in: {a: t.sum}}\n")
                .find("input 'a' of 'u' (story.add) is not connected"),
            std::string::npos);
}

TEST(RoleExpansion, ACopyThatIsCalledLikeAnotherNodeIsRefused) {
  const std::string said =
      refusal("s: {for_each: source.value, use: \"${kind}\"}\ns_story_constant: {use: story.constant}\n");
  EXPECT_NE(said.find("would be called 's_story_constant', and so is another node"), std::string::npos) << said;
}

TEST(RoleExpansion, ARoleThatIsNotThereIsGuessed) {
  const std::string said = refusal("s: {for_each: sourse.value, use: \"${kind}\"}\nc: {use: story.constant}\n");
  EXPECT_NE(said.find("there is no role 'sourse' — did you mean 'source'?"), std::string::npos) << said;
}

TEST(RoleExpansion, ANodeThatTakesOneRunsForEachItem) {
  Story story(
      "a: {use: story.series, with: {values: [1, 2, 3]}}\n"
      "b: {use: story.add, each: a, in: {a: a.numbers}, with: {offset: 10}}\n"
      "t: {use: story.sum, in: {numbers: b.sum}}\n");
  ASSERT_TRUE(story.run().ok());
  EXPECT_EQ(story.node("b").items, 3u);
  EXPECT_EQ(value_of(story, "t", "sum"), 1 * 11 + 2 * 12 + 3 * 13);
  Story none(
      "a: {use: story.series, with: {values: []}}\nb: {use: story.add, each: a, in: {a: a.numbers}}\n"
      "t: {use: story.sum, in: {numbers: b.sum}}\n");
  ASSERT_TRUE(none.run().ok());
  EXPECT_EQ(value_of(none, "t", "sum"), 0);
  EXPECT_NE(refusal("a: {use: story.series}\nb: {use: story.square, each: number, in: {number: a.numbers}}\n")
                .find("runs for each item of 'number' already"),
            std::string::npos);
  EXPECT_NE(refusal("a: {use: story.series}\nb: {use: story.add, each: c, in: {a: a.numbers}}\n")
                .find("'story.add' has no input 'c'"),
            std::string::npos);
}

}  // namespace test_role_expansion
}  // namespace plumbline::test

#include "runtime/run/key.hpp"
#include "story.hpp"

namespace plumbline::test {
namespace test_key {

TEST(Key, FieldsCannotRunIntoEachOther) {
  EXPECT_NE(runtime::key_of({{"a", "b"}, {"c", "d"}}), runtime::key_of({{"a", "bc"}, {"", "d"}}));
  EXPECT_NE(runtime::key_of({{"a", ""}}), runtime::key_of({{"", "a"}}));
}

TEST(Key, HoldsAllThatCounts) {
  Story story("a: {use: story.add, in: {a: c.number}}\nc: {use: story.constant}");
  story.run();
  const auto& fields = story.node("a").fields;
  for (const char* name : {"abi", "kind", "version", "plugin binary", "parameter offset", "parameter mode", "input a"})
    EXPECT_TRUE(fields.count(name)) << name;
  EXPECT_FALSE(fields.count("input b")) << "it is not connected";
  EXPECT_EQ(fields.at("plugin binary").size(), 64u);
}

TEST(Key, SeedsAreFixedForAllTime) {
  // Results of published runs hang on these: they must not change with the program.
  EXPECT_NE(runtime::seed_of(1, "campaign", 0), runtime::seed_of(2, "campaign", 0));
  EXPECT_NE(runtime::seed_of(1, "campaign", 0), runtime::seed_of(1, "campaign", 1));
  EXPECT_NE(runtime::seed_of(1, "campaign", 0), runtime::seed_of(1, "other", 0));
  EXPECT_EQ(runtime::seed_of(1, "campaign", 0), 14092481104256623737u);
}

TEST(Key, ChangesAreNamedInShort) {
  const std::string before(64, 'a'), now(64, 'b');
  EXPECT_EQ(
      runtime::compare({{"x", before}, {"old", "1"}, {"same", "s"}}, {{"x", now}, {"new", "2"}, {"same", "s"}}),
      (std::vector<std::string>{"new: new, 2", "old: no longer there, was 1", "x: aaaaaaaaaaaa -> bbbbbbbbbbbb"}));
}

}  // namespace test_key
}  // namespace plumbline::test

#include "story.hpp"

namespace plumbline::test {
namespace test_plan {

/// "run a: reason", one line a node.
std::string tell(const Story& story, const std::vector<runtime::PlannedNode>& planned) {
  std::string text;
  for (size_t i = 0; i < planned.size(); ++i) {
    text += std::string(planned[i].runs ? "run " : "reuse ") + story.graph.nodes[i].name;
    for (const std::string& reason : planned[i].reasons) text += ": " + reason;
    text += "\n";
  }
  return text;
}

TEST(Plan, NothingRanYet) {
  Story story("a: {use: story.constant}\nb: {use: story.add, in: {a: a.number}}");
  EXPECT_EQ(tell(story, story.plan()),
            "run a: never ran in this pipeline\n"
            "run b: its input 'a' will be recomputed by 'a'\n");
}

TEST(Plan, NamesTheParameterThatChanged) {
  Story story(small_chain);
  story.run();
  EXPECT_EQ(tell(story, story.plan()), "reuse a\nreuse b\nreuse c\nreuse d\n");
  EXPECT_EQ(tell(story, story.plan({"b.with.offset=2.5"})),
            "reuse a\n"
            "run b: parameter offset: 1 -> 2.5\n"
            "run c: its input 'a' will be recomputed by 'b'\n"
            "reuse d\n");
}

TEST(Plan, NamesKindAndSeed) {
  Story story("d: {use: story.draw}\ne: {use: story.constant}");
  story.run();
  EXPECT_EQ(tell(story, story.plan({"seed=7"})), "run d: seed: 1 -> 7\nreuse e\n");
  const std::string changed = tell(story, story.plan({"e.use=story.draw"}));
  EXPECT_NE(changed.find("run e: kind: story.constant -> story.draw"), std::string::npos) << changed;
}

TEST(Plan, CountsItems) {
  Story story("s: {use: story.series}\nq: {use: story.square, in: {number: s.numbers}}");
  story.run();
  story.run({"s.with.values=[1, 2, 3, 4, 5]"});
  story.move_contents_to_blobs();
  std::filesystem::remove(story.blob(story.node("q").outputs.at("square").at(4)));
  const auto planned = story.plan({"s.with.values=[1, 2, 3, 4, 5]"});
  EXPECT_EQ(planned.at(1).items, 5u);
  EXPECT_EQ(planned.at(1).items_to_run, 1u);
}

TEST(Plan, SaysThatAResultIsDamaged) {
  Story story("a: {use: story.constant}");
  story.run();
  story.move_contents_to_blobs();
  std::filesystem::remove(story.blob(story.node("a").outputs.at("number").at(0)));
  const auto planned = story.plan();
  ASSERT_EQ(planned.at(0).reasons.size(), 1u);
  EXPECT_NE(planned[0].reasons[0].find("is missing in the store"), std::string::npos) << planned[0].reasons[0];
}

TEST(Plan, RunsNothing) {
  Story story(small_chain);
  story.plan();
  EXPECT_TRUE(std::filesystem::is_empty(story.folder.path() / "store" / "runs"));
}

}  // namespace test_plan
}  // namespace plumbline::test

// Pipelines with rounds: what one round gives the next one takes.
#include <gmock/gmock.h>

#include "runtime/record/run_record.hpp"
#include "story.hpp"

namespace plumbline::test {
namespace test_rounds {

using runtime::NodeStatus;
using testing::ElementsAre;
using testing::HasSubstr;

/// Heron's rule for the root of `of`: x becomes (x + of / x) / 2 by the nodes of a story, here as x + offset.
const std::string count_to_five =
    "start: {use: story.constant, with: {value: 1}}\n"
    "up: {use: story.add, in: {a: rounds.x}, with: {offset: 1}}\n"
    "after: {use: story.add, in: {a: up.sum}, with: {offset: 100}}\n"
    "all: {use: story.sum, in: {numbers: rounds.all.x}}\n"
    "aside: {use: story.constant, with: {value: 7}}";
const std::string rounds = "rounds: {carry: {x: {first: start.number, next: up.sum}}, until: up.sum >= 5, most: 10}\n";

std::string statuses(const Story& story, const std::string& name) {
  std::string text;
  for (const auto& node : story.result.earlier)
    if (story.graph.nodes[node.node].name == name) text += std::string(to_text(node.result.status)) + " ";
  return text + story.status(name);
}

std::string problems(Story& story) {
  try {
    story.run();
  } catch (const runtime::InvalidPipeline& error) {
    return error.what();
  }
  return "";
}

TEST(Rounds, GoOnUntilTheConditionHolds) {
  Story story(count_to_five, rounds);
  story.run();
  EXPECT_TRUE(story.result.ok());
  EXPECT_EQ(story.result.rounds.rounds, 4u) << "1 becomes 2, 3, 4, 5";
  EXPECT_TRUE(story.result.rounds.finished);
  EXPECT_EQ(story.result.rounds.text, "up.sum >= 5 holds (5)");
  EXPECT_EQ(story.value("up", "sum"), 5);
  EXPECT_EQ(story.value("after", "sum"), 105) << "what comes after them takes the last round's";
  EXPECT_EQ(story.value("all", "sum"), 1 * 2 + 2 * 3 + 3 * 4 + 4 * 5) << "or that of all, in their order";
  EXPECT_EQ(statuses(story, "up"), "executed executed executed executed");
  EXPECT_EQ(statuses(story, "start"), "executed") << "what no round changes runs once";
  EXPECT_EQ(statuses(story, "after"), "executed");
  EXPECT_EQ(statuses(story, "aside"), "executed");
}

/// The same numbers as by hand, one run after the other.
TEST(Rounds, GiveWhatTheSameRunsByHandGive) {
  Story story(count_to_five, rounds);
  story.run();
  Story by_hand("start: {use: story.constant}\nup: {use: story.add, in: {a: start.number}, with: {offset: 1}}");
  double x = 1;
  for (int i = 0; i < 4; ++i) {
    by_hand.run({"start.with.value=" + std::to_string(x)});
    x = by_hand.value("up", "sum");
  }
  EXPECT_EQ(by_hand.node("up").outputs, story.node("up").outputs);
  EXPECT_EQ(by_hand.node("up").keys, story.node("up").keys) << "a round is an ordinary run: it has the same key";
}

TEST(Rounds, AreReusedAndGoOnWhereTheyWere) {
  Story story(count_to_five, rounds);
  story.run({"rounds.most=2"});
  EXPECT_FALSE(story.result.rounds.finished);
  EXPECT_EQ(story.result.rounds.rounds, 2u);
  EXPECT_EQ(story.result.rounds.text, "up.sum >= 5 does not hold (3)");
  story.run();
  EXPECT_EQ(statuses(story, "up"), "reused reused executed executed");
  story.run();
  EXPECT_EQ(story.result.count(NodeStatus::executed), 0u);
  EXPECT_EQ(statuses(story, "up"), "reused reused reused reused");
}

TEST(Rounds, WithoutAConditionEndWhenNothingChangesAnyMore) {
  // 1 -> mode double of (x - 1): 2·(1 - 1) = 0, then 2·(0 - 1) = -2, ...; and x·1 + 0 stays.
  Story still("s: {use: story.constant, with: {value: 3}}\nn: {use: story.add, in: {a: rounds.x}}",
              "rounds: {carry: {x: {first: s.number, next: n.sum}}, most: 10}\n");
  still.run();
  EXPECT_EQ(still.result.rounds.rounds, 2u);
  EXPECT_TRUE(still.result.rounds.finished);
  still.tell("s: {use: story.constant, with: {value: 3}}\nn: {use: story.add, in: {a: rounds.x}}",
             "rounds: {carry: {x: {first: s.number, next: n.sum}}, until: n.sum > 5, most: 10}\n");
  still.run();
  EXPECT_EQ(still.result.rounds.rounds, 2u) << "no later round could change it";
  EXPECT_FALSE(still.result.rounds.finished);
  EXPECT_THAT(still.result.rounds.text, HasSubstr("no later round can change that"));
  // Who draws a number may give another one for the same.
  still.tell(
      "s: {use: story.constant, with: {value: 3}}\nn: {use: story.add, in: {a: rounds.x, b: d.number}, with: {}}\n"
      "d: {use: story.draw, in: {after: rounds.x}}",
      "rounds: {carry: {x: {first: s.number, next: s2.sum}}, most: 4}\n");
}

/// The first round draws what a run without rounds draws; each later one something else.
TEST(Rounds, EachDrawsASeedOfItsOwn) {
  const std::string nodes = "s: {use: story.constant}\nd: {use: story.draw, in: {after: rounds.x}}";
  Story story(nodes, "rounds: {carry: {x: {first: s.number, next: d.number}}, most: 3}\n");
  story.run();
  std::set<std::vector<std::string>> drawn{story.node("d").outputs.at("number")};
  for (const auto& node : story.result.earlier) drawn.insert(node.result.outputs.at("number"));
  EXPECT_EQ(drawn.size(), 3u);
  Story once("s: {use: story.constant}\nd: {use: story.draw, in: {after: s.number}}");
  once.run();
  EXPECT_EQ(drawn.count(once.node("d").outputs.at("number")), 1u);
  EXPECT_EQ(story.result.rounds.rounds, 3u);
  story.run();
  EXPECT_EQ(story.result.count(NodeStatus::executed), 0u);
}

TEST(Rounds, AnInputMayBeEmptyInTheFirst) {
  Story story("a: {use: story.constant, with: {value: 1}}\nup: {use: story.add, in: {a: a.number, b: rounds.x}}",
              "rounds: {carry: {x: up.sum}, until: up.sum >= 4, most: 10}\n");
  story.run();
  EXPECT_EQ(story.result.rounds.rounds, 4u);
  EXPECT_EQ(story.value("up", "sum"), 4);
}

/// Lists are carried as lists, and nodes that run once for each item run so in each round.
TEST(Rounds, CarryLists) {
  Story story(
      "s: {use: story.series, with: {values: [1, 2, 3]}}\nq: {use: story.square, in: {number: rounds.x}}\n"
      "t: {use: story.sum, in: {numbers: q.square}}",
      "rounds: {carry: {x: {first: s.numbers, next: q.square}}, most: 2}\n");
  story.run();
  EXPECT_THAT(story.values("q", "square"), ElementsAre(1, 16, 81));
  EXPECT_EQ(story.value("t", "sum"), 1 + 2 * 16 + 3 * 81);
}

/// Several connections of one list, such as readers of several plugins, in the order in which they are written.
TEST(Rounds, ListsMayHaveSeveralConnections) {
  const std::string nodes =
      "a: {use: story.series, with: {values: [1, 2]}}\nb: {use: story.constant, with: {value: 5}}\n"
      "before: {use: story.sum, in: {numbers: [b.number, a.numbers]}}\n"
      "up: {use: story.add, in: {a: rounds.x, b: before.sum}}\ndown: {use: story.add, in: {a: rounds.x}}\n"
      "within: {use: story.sum, in: {numbers: [up.sum, down.sum]}}\nmore: {use: story.add, in: {a: within.sum}}\n"
      "again: {use: story.add, in: {a: within.sum}, with: {offset: 1}}\n"
      "after: {use: story.sum, in: {numbers: [more.sum, again.sum]}}\nlast: {use: story.sum, in: {numbers: [b.number, "
      "a.numbers]}}";
  const std::string twice = "rounds: {carry: {x: {first: b.number, next: within.sum}}, most: 2}\n";
  Story story(nodes, twice);
  story.run();
  EXPECT_TRUE(story.result.ok());
  const double before = 5 + 2 * 1 + 3 * 2, first = (5 + before) + 2 * 5, second = (first + before) + 2 * first;
  EXPECT_EQ(story.value("before", "sum"), before);
  EXPECT_EQ(story.value("within", "sum"), second);
  EXPECT_EQ(story.value("after", "sum"), second + 2 * (second + 1));
  EXPECT_EQ(story.value("last", "sum"), before);
  EXPECT_EQ(statuses(story, "before"), "executed");
  Story mixed(nodes + "\nmix: {use: story.sum, in: {numbers: [b.number, up.sum]}}", twice);
  EXPECT_THAT(problems(mixed),
              HasSubstr("takes 'b' and 'up', of which one belongs to the rounds and the other does not"));
  Story beside(nodes + "\nmix: {use: story.sum, in: {numbers: [b.number, rounds.x]}}", twice);
  EXPECT_THAT(problems(beside), HasSubstr("takes one connection where one of them comes from the rounds"));
}

TEST(Rounds, AFailureInOneNamesItAndWhatDependsOnItIsSkipped) {
  Story story(
      "s: {use: story.series, with: {values: [1, -2]}}\nminus: {use: story.add, in: {a: rounds.x}, with: {offset: "
      "-1}}\n"
      "one: {use: story.constant, with: {value: 1}}\nlist: {use: story.throws, in: {number: minus.sum}}\n"
      "after: {use: story.add, in: {a: minus.sum}}\naside: {use: story.constant, with: {value: 9}}",
      "rounds: {carry: {x: {first: one.number, next: minus.sum}}, until: list.never, most: 5}\n");
  story.run();
  EXPECT_FALSE(story.result.ok());
  EXPECT_EQ(story.status("list"), "failed");
  EXPECT_EQ(story.status("after"), "skipped");
  EXPECT_EQ(story.node("after").error, "it comes after the rounds, in which 'list' failed");
  EXPECT_EQ(story.status("aside"), "executed") << "what the rounds do not touch goes on";
}

TEST(Rounds, AMetricThatNobodyGivesIsNamed) {
  Story story(count_to_five, "rounds: {carry: {x: {first: start.number, next: up.sum}}, until: up.done, most: 10}\n");
  story.run();
  EXPECT_FALSE(story.result.ok());
  EXPECT_EQ(story.result.rounds.problem, "'up' gave no metric 'done' in round 1; it gave sum");
  EXPECT_EQ(story.status("after"), "skipped");
}

TEST(Rounds, WhatIsWrongWithThemIsToldWithItsPlace) {
  const std::pair<const char*, const char*> wrong[] = {
      {"rounds: {carry: {x: {first: start.number, next: up.sum}}, until: up.sum >= 5}\n", "'rounds' must say how many"},
      {"rounds: {carry: {x: {first: start.number, next: up.sum}}, most: 0}\n", "(1 to 100000), found '0'"},
      {"rounds: {carry: {x: {first: start.numbr, next: up.sum}}, most: 3}\n", "did you mean 'number'?"},
      {"rounds: {carry: {y: {first: start.number, next: up.sum}}, most: 3}\n",
       "nothing is carried from round to round as 'x' — did you mean 'y'?"},
      {"rounds: {carry: {x: {first: start.number, next: up.sum}, z: up.sum}, most: 3}\n",
       "nothing takes what is carried as 'z'"},
      {"rounds: {carry: {x: up.sum}, most: 3}\n", "must be connected in the first round, too"},
      {"rounds: {carry: {x: {first: start.number, next: aside.number}}, most: 3}\n",
       "'aside' takes nothing from the round before"},
      {"rounds: {carry: {x: {first: start.number, next: up.sum}}, until: aside.sum, most: 3}\n",
       "'aside' takes nothing from the round before"},
      {"rounds: {carry: {x: {first: start.number, next: up.sum}}, until: uq.sum, most: 3}\n", "did you mean 'up'?"},
      {"rounds: {carry: {x: {first: start.number, next: up.sum}}, until: up.sum > five, most: 3}\n",
       "'until' is a metric of a node"},
      {"rounds: {carry: {x: {first: start.number, next: up.sum}}, unti: up.sum, most: 3}\n",
       "rounds has no key 'unti' — did you mean 'until'?"},
      {"rounds: {carry: {x: {first: start.number, next: up.sum}}, until: all.sum, most: 3}\n",
       "'all' takes what all rounds gave, but the rounds need it"},
      {"", "there is no node 'rounds'"},
  };
  for (const auto& [text, words] : wrong) {
    Story story(count_to_five, text);
    EXPECT_THAT(problems(story), HasSubstr(words)) << text;
  }
  Story folder("f: {use: story.folder}\nup: {use: story.add, in: {a: rounds.x}}",
               "rounds: {carry: {x: {first: f.folder, next: up.sum}}, most: 3}\n");
  EXPECT_THAT(problems(folder), HasSubstr("takes plumbline.Number/1"));
}

TEST(Rounds, APlanKnowsThoseThatAreInTheStore) {
  Story story(count_to_five, rounds);
  auto planned = story.plan();
  EXPECT_EQ(planned.size(), 5u) << "one round, and what comes after it";
  story.run({"rounds.most=2"});
  planned = story.plan();
  std::string text;
  for (const auto& node : planned)
    text += runtime::label_of(story.graph.nodes[node.node].name, node.round) +
            (node.runs ? node.is_sure ? "!" : "?" : "") + " ";
  EXPECT_EQ(text, "start up up, round 2 up, round 3! aside after? all? ");
  EXPECT_THAT(planned.back().reasons.at(0), HasSubstr("of which number 3 is still to be computed"));
  story.run();
  for (const auto& node : story.plan()) EXPECT_FALSE(node.runs);
}

/// Two carried values that trade places: each round takes both of the round before, not one of its own.
TEST(Rounds, AllThatIsCarriedIsOfTheRoundBefore) {
  Story story(
      "p: {use: story.constant, with: {value: 1}}\nq: {use: story.constant, with: {value: 1}}\n"
      "older: {use: story.add, in: {a: rounds.young}}\n"
      "young: {use: story.add, in: {a: rounds.old, b: rounds.young}}",
      "rounds: {carry: {old: {first: p.number, next: older.sum}, young: {first: q.number, next: young.sum}}, "
      "most: 8}\n");
  story.run();
  EXPECT_EQ(story.value("young", "sum"), 55) << "Fibonacci's 1, 1, 2, 3, 5, 8, 13, 21, 34, 55";
}

}  // namespace test_rounds
}  // namespace plumbline::test

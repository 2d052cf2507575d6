// A job among the rounds of a site: one that a later round went on from is not sent, and what a robot was given in a
// round before is not asked for again before somebody has said what became of it.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "loop/exchange/order_exchange.hpp"
#include "loop/exchange/rounds_beside.hpp"
#include "two_floors.hpp"

namespace plumbline::loop {
namespace test_rounds_beside {

namespace fs = std::filesystem;

std::string change(const std::string& item, const std::string& from, const std::string& to) {
  return R"({"item":")" + item + R"(","kind":"bracket","from":")" + from + R"(","to":")" + to + "\"}\n";
}

std::string released(const std::string& item) { return change(item, "PLANNED", "RELEASED"); }
std::string recalled(const std::string& item) {
  return change(item, "RELEASED", "STALE") + change(item, "STALE", "PLANNED");
}

Job job_of(const std::string& id, const std::vector<std::pair<std::string, int>>& items) {
  Job job;
  job.id = id, job.revision = 1;
  for (const auto& [name, revision] : items) {
    JobItem item;
    item.id = name, item.kind = "bracket", item.operation = "setBracket", item.revision = revision, item.floor = 1;
    job.revision = std::max(job.revision, revision);
    job.items.push_back(item);
  }
  return job;
}

/// rounds/1 and rounds/2 as site_loop leaves them, and robots with a folder each.
class RoundsBeside : public ::testing::Test {
 protected:
  void SetUp() override {
    fs::remove_all(folder_);
    for (const char* name : {"rounds/1", "rounds/2", "rounds/of another site"}) fs::create_directories(folder_ / name);
    write("rounds/1/journal.jsonl", first_);
    write("rounds/of another site/journal.jsonl", released("z"));
    write("rounds/of another site/job.json.given.jsonl", given("a", 1, "RC/9", "job-1"));
  }
  void TearDown() override { fs::remove_all(folder_); }

  void write(const std::string& name, const std::string& text) { std::ofstream(folder_ / name) << text; }
  static std::string given(const std::string& item, int revision, const std::string& robot, const std::string& order) {
    return R"({"item":")" + item + R"(","revision":)" + std::to_string(revision) + R"(,"robot":")" + robot +
           R"(","order":")" + order + "\"}\n";
  }
  /// Why the job of that round is not sent to RC/`serial`.
  std::string reason(const std::string& round, const Job& job, const std::string& serial = "1") {
    const VdaRobot robot{VdaVersion::v2_0, "RC", serial, 0, "", std::nullopt};
    const fs::path rounds = folder_ / "rounds" / round;
    ExchangeFolder log(folder_ / "robots" / serial, rounds / "job.json.given.jsonl", rounds);
    return OrderExchange(job, robot, log).reason();
  }

  const fs::path folder_ = fs::temp_directory_path() / ("plumbline_rounds_" + std::to_string(getpid()));
  const std::string first_ = released("a") + released("b");
};

TEST_F(RoundsBeside, AJobThatALaterRoundWentOnFromIsNotSent) {
  const Job job = job_of("job-1", {{"a", 1}, {"b", 1}});
  EXPECT_EQ(reason("1", job), "");
  // A run that went on from there and was killed, or taken away, counts for nothing.
  write("rounds/1/journal.next", "../2\n../3\n");
  EXPECT_EQ(reason("1", job), "");
  write("rounds/2/journal.jsonl", first_ + recalled("a"));
  const std::string why = reason("1", job);
  EXPECT_NE(why.find("2 went on from that round"), std::string::npos) << why;
  EXPECT_NE(why.find("rounds/2/job.json"), std::string::npos) << why;
  EXPECT_EQ(reason("2", job_of("job-2", {{"b", 1}})), "");
}

TEST_F(RoundsBeside, WhatARobotWasGivenBeforeIsNotAskedForAgain) {
  write("rounds/1/job.json.given.jsonl", given("a", 1, "RC/1", "job-1") + given("b", 1, "RC/1", "job-1"));
  write("rounds/2/journal.jsonl", first_ + recalled("a") + released("a"));
  // Neither by another robot nor by the one that has it, whose other order it would be; b was not even recalled.
  for (const char* serial : {"1", "2"})
    for (const auto& item : {std::pair("a", 2), std::pair("b", 1)}) {
      const std::string why = reason("2", job_of("job-2", {item}), serial);
      EXPECT_EQ(why.find(std::string(item.first) + " was given to RC/1"), 0u) << serial << item.first << why;
      EXPECT_NE(why.find("no report of it is in this round"), std::string::npos) << why;
    }
  EXPECT_EQ(reason("2", job_of("job-2", {{"c", 2}})), "") << "what nobody was given";
}

/// Sent from a copy of the job, or by a folder that is gone: the robot has it all the same.
TEST_F(RoundsBeside, AnOrderThatTheRobotHasIsItsWhoeverSentIt) {
  const Job job = job_of("job-1", {{"a", 1}});
  const VdaRobot robot{VdaVersion::v2_0, "RC", "1", 0, "", std::nullopt};
  const fs::path rounds = folder_ / "rounds/1";
  {
    ExchangeFolder log(folder_ / "robots/1", rounds / "job.json.given.jsonl", rounds);
    OrderExchange exchange(job, robot, log);
    exchange.due(100, "2026-05-02T08:00:00Z");
    exchange.on_state(R"({"headerId": 1, "timestamp": "2026-05-02T08:00:01Z", "manufacturer": "RC", "serialNumber": "1",
                          "orderId": "job-1", "actionStates": [{"actionId": "job-1:a:1", "actionStatus": "FINISHED"}]})",
                      101);
    EXPECT_EQ(exchange.status(), ExchangeStatus::finished);
  }
  write("rounds/2/journal.jsonl", first_ + recalled("a") + released("a"));
  EXPECT_EQ(reason("2", job_of("job-2", {{"a", 2}}), "2").find("a was given to RC/1"), 0u);
}

TEST_F(RoundsBeside, WhatWasReportedSinceIs) {
  write("rounds/1/job.json.given.jsonl", given("a", 1, "RC/1", "job-1"));
  const std::vector<std::string> answers = {
      change("a", "RELEASED", "EXECUTED") + change("a", "EXECUTED", "REWORK") + change("a", "REWORK", "PLANNED"),
      change("a", "RELEASED", "PLANNED"),  // failed or skipped
      change("a", "RELEASED", "REJECTED") + change("a", "REJECTED", "PLANNED")};
  for (const std::string& answer : answers) {
    write("rounds/2/journal.jsonl", first_ + answer + released("a"));
    EXPECT_EQ(reason("2", job_of("job-2", {{"a", 2}})), "") << answer;
  }
}

/// One file for all rounds: what was done by the release before is known, of the last one it is not.
TEST_F(RoundsBeside, OneFileForAllRoundsIsHeldAgainstTheJournal) {
  const Job third = job_of("job-3", {{"a", 3}});
  const std::string done = change("a", "RELEASED", "EXECUTED") + change("a", "EXECUTED", "PLANNED");
  write("given.jsonl", given("a", 1, "RC/1", "job-1") + given("a", 2, "RC/1", "job-2"));
  write("rounds/2/journal.jsonl", first_ + done + released("a") + recalled("a") + released("a"));
  const fs::path round = folder_ / "rounds/2";
  EXPECT_EQ(unanswered(round, folder_ / "given.jsonl", third, "RC/1", "job-3").size(), 1u);
  write("rounds/2/journal.jsonl", first_ + done + released("a") + done + released("a"));
  EXPECT_TRUE(unanswered(round, folder_ / "given.jsonl", third, "RC/1", "job-3").empty());
  for (const char* line : {"nonsense\n", "{\"item\":1,\"revision\":\"x\",\"robot\":3}\n"}) {
    write("given.jsonl", line);
    EXPECT_THROW(given_lines(folder_ / "given.jsonl"), std::runtime_error);
  }
}

/// The first release given to a robot, in its first lines of the journal reported failed; then recalled twice.
TEST_F(RoundsBeside, WhatWasAnsweredLongAgoIsNotHeldByOneFileForAllRounds) {
  write("rounds/1/journal.jsonl", released("a"));
  {
    ExchangeFolder log(folder_ / "robots/1", folder_ / "given.jsonl", folder_ / "rounds/1");
    EXPECT_EQ(log.held_by_others(job_of("job-1", {{"a", 1}}), "RC/1", true), "");
  }
  ASSERT_EQ(given_lines(folder_ / "given.jsonl").size(), 1u);
  ASSERT_EQ(given_lines(folder_ / "given.jsonl").at(0).since, 1u);
  write("rounds/2/journal.jsonl",
        released("a") + change("a", "RELEASED", "PLANNED") + released("a") + recalled("a") + released("a"));
  EXPECT_TRUE(
      unanswered(folder_ / "rounds/2", folder_ / "given.jsonl", job_of("job-3", {{"a", 3}}), "RC/1", "job-3").empty());
  write("rounds/2/journal.jsonl", released("a") + recalled("a") + released("a"));
  EXPECT_EQ(
      unanswered(folder_ / "rounds/2", folder_ / "given.jsonl", job_of("job-3", {{"a", 3}}), "RC/1", "job-3").size(),
      1u);
}

/// Rounds as they are run: released, given to RC/1, recalled because control moved, done all the same.
class RecalledAndDone : public RoundsBeside {
 protected:
  void SetUp() override {
    RoundsBeside::SetUp();
    next("first", "08:00");
    keep("1");
    write("rounds/1/job.json.given.jsonl", given("b0", 1, "RC/1", "job-1") + given("b1", 1, "RC/1", "job-1"));
    test::recall(state_, {}, "control point CP1 moved");
    keep("2");
    ASSERT_EQ(test::item(state_, "b0").status, ItemStatus::planned);
  }

  static std::string at(const std::string& hour) { return "2026-05-04T" + hour + ":00Z"; }
  void next(const std::string& basis, const std::string& hour, double off = 0) {
    test::MachineOptions options;
    options.at = options.measured_at = at(hour);
    InstallationPlanT plan = test::make_plan(basis);
    for (auto& bracket : plan.brackets) bracket->measured.z() += off, bracket->setting.y() -= off;
    test::next_plan(state_, std::move(plan), options);
  }
  void keep(const std::string& round) {
    std::string lines;
    for (const std::string& line : state_.journal) lines += line + "\n";
    fs::create_directories(folder_ / "rounds" / round);
    write("rounds/" + round + "/journal.jsonl", lines);
  }
  /// What RC/1 says of its order; how many reports are refused.
  std::size_t report(const std::string& outcome, const std::string& hour, const std::string& now) {
    ActualsT actuals = test::done({"b0", "b1"}, 1);
    for (auto& one : actuals.items) one->by = "RC/1", one->job = "job-1", one->at = at(hour), one->outcome = outcome;
    return test::apply_actuals(state_, actuals, nullptr, at(now)).size();
  }
  std::string reason_now() {
    const int revision = test::item(state_, "b0").revision;
    return reason("3", job_of("job-3", {{"b0", revision}, {"b1", revision}}));
  }

  LoopStateT state_;
};

TEST_F(RecalledAndDone, IsAskedForAgainOnceItIsMeasuredAfterThat) {
  EXPECT_EQ(report("done", "10:00", "17:00"), 2u) << "refused: nobody asked for it any more";
  const std::size_t lines = state_.journal.size();
  EXPECT_EQ(report("done", "10:00", "17:00"), 2u);
  EXPECT_EQ(state_.journal.size(), lines) << "the file is read again: once in the journal";
  // Measured before the robot did it: what is asked for would be set twice.
  next("second", "09:30");
  keep("3");
  ASSERT_EQ(test::item(state_, "b0").status, ItemStatus::released);
  EXPECT_EQ(reason_now().find("b0, b1 were given to RC/1 itself, in order job-1"), 0u) << reason_now();
  // Measured since; 1 mm is none that goes to a person, and the setting that was planned before is not asked for.
  next("third", "17:30", 0.001);
  keep("3");
  ASSERT_EQ(test::item(state_, "b0").status, ItemStatus::released);
  EXPECT_EQ(test::item(state_, "b0").revision, 3);
  EXPECT_NEAR(test::item(state_, "b0").pending.y(), 0.003, 1e-12);
  EXPECT_EQ(reason_now(), "");
  EXPECT_EQ(test::check_journal(state_.journal).words, "");
}

TEST_F(RecalledAndDone, WithTheRoundThatMeasuredIt) {
  EXPECT_EQ(report("failed", "10:00", "17:00"), 2u);
  next("second", "16:30");
  keep("3");
  EXPECT_EQ(reason_now(), "");
}

TEST_F(RecalledAndDone, WhatWasSkippedIsAnsweredAtOnce) {
  next("second", "09:30");
  EXPECT_EQ(report("skipped", "10:00", "17:00"), 2u);
  keep("3");
  ASSERT_EQ(test::item(state_, "b0").status, ItemStatus::released);
  EXPECT_EQ(test::item(state_, "b0").revision, 2);
  EXPECT_EQ(reason_now(), "");
}

/// A report on an order that was never recalled, read again rounds later, is none of a recalled one.
TEST_F(RecalledAndDone, OldReportsOfWhatWasTakenLeaveNoLine) {
  LoopStateT state;
  test::next_plan(state, test::make_plan("first"));
  const ActualsT actuals = test::done({"b0", "b1"}, 1);
  EXPECT_TRUE(test::apply_actuals(state, actuals).empty());
  test::next_plan(state, test::plan_after_setting(0));
  const std::size_t lines = state.journal.size();
  EXPECT_EQ(test::apply_actuals(state, actuals).size(), 2u);
  EXPECT_EQ(state.journal.size(), lines);
}

}  // namespace test_rounds_beside
}  // namespace plumbline::loop

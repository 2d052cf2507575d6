// A job among the rounds of a site: one that a later round went on from is not sent, and what a robot was given in a
// round before is not asked for again before somebody has said what became of it.
#include "loop/exchange/rounds_beside.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "loop/exchange/order_exchange.hpp"

namespace plumbline::loop {
namespace rounds_beside_test {

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

}  // namespace rounds_beside_test
}  // namespace plumbline::loop

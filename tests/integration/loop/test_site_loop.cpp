// site_loop.yaml as a site runs it: a folder for each campaign, reports as files, a state from round to round, until
// every panel hangs. The site is simulated here, and goes in as files only.
#include <functional>
#include <map>
#include <set>

#include "site_in_files.hpp"

namespace plumbline::test {
namespace test_site_loop {

TEST(SiteLoop, RoundAfterRoundUntilEveryPanelHangs) {
  const Program plumbline;
  Site site(plumbline);
  std::string summary;
  int round = 1;
  for (; round < 16; ++round) {
    site.measure(round);
    const Answer answer = run_round(plumbline, round);
    ASSERT_EQ(answer.code, 0) << answer.out << answer.err;
    const fs::path out = plumbline.work() / ("round" + std::to_string(round));
    for (const char* name : {"state.json", "journal.jsonl", "job.json", "as_built.ifc", "issues.bcf", "loop.html",
                             "layout_hilti.csv", "summary.txt"})
      EXPECT_TRUE(fs::exists(out / name)) << name;
    summary = read_file(out / "summary.txt");
    // Who sets by hand sets what robots would, and nothing that waits.
    std::istringstream rows(read_file(out / "settings.csv"));
    std::set<std::string> by_hand, by_robots;
    std::string row;
    for (std::getline(rows, row); std::getline(rows, row);) by_hand.insert(row.substr(0, row.find(';')));
    for (const loop::JobItem& item : loop::read_job(read_file(out / "job.json")).items)
      if (item.kind == "bracket") by_robots.insert(item.id);
    EXPECT_EQ(by_hand, by_robots) << round;
    if (contains(summary, "next: nothing: every panel hangs")) break;
    site.work(round);
  }
  EXPECT_TRUE(contains(summary, "next: nothing: every panel hangs within its limits")) << summary;
  const std::string out = "round" + std::to_string(round);
  EXPECT_EQ(plumbline({"journal", out, "--check"}).code, 0);
  EXPECT_TRUE(contains(read_file(plumbline.work() / out / "as_built.ifc"), "ASB_InstallationState"));
  // The same words again: nothing is computed, and nothing is another one.
  const std::string state = read_file(plumbline.work() / out / "state.json");
  EXPECT_EQ(run_round(plumbline, round).code, 0);
  EXPECT_EQ(read_file(plumbline.work() / out / "state.json"), state);
}

/// The upper floor is not there yet: it was "nothing: every panel hangs" when the lower one hung.
TEST(SiteLoop, AFloorThatNobodyMeasuredIsNoEnd) {
  const Program plumbline;
  Site site(plumbline);
  std::string summary;
  for (int round = 1; round < 12; ++round) {
    site.measure(round, "F02");
    const Answer answer = run_round(plumbline, round);
    ASSERT_EQ(answer.code, 0) << "its job is right" << answer.out << answer.err;
    summary = read_file(plumbline.work() / ("round" + std::to_string(round)) / "summary.txt");
    ASSERT_FALSE(contains(summary, "every panel hangs")) << summary;
    if (site.work(round) == 0) break;
  }
  EXPECT_TRUE(contains(summary, "2 of 4 panels hang and are verified")) << summary;
  EXPECT_TRUE(contains(summary, "next: measure the anchors of the panels below that are not planned, then run again"))
      << summary;
  EXPECT_TRUE(contains(summary, "floor 2: F02-P01, F02-P02 are not planned: not one anchor there was measured"))
      << summary;
}

/// What was measured in part is no floor that is not built yet.
TEST(SiteLoop, APanelThatWasMeasuredInPartIsTold) {
  const Program plumbline;
  Site site(plumbline);
  site.measure(1, "F02-C03-R2");
  const Answer answer = run_round(plumbline, 1);
  EXPECT_EQ(answer.code, 3) << answer.err;
  EXPECT_TRUE(contains(answer.err, "Measured in part: F02-P02 without F02-C03-R2: measure what is missing"))
      << answer.err;
}

/// A panel that hangs hides plates of its own: nobody can measure them any more, and no round ends with exit code 3 by
/// that.
TEST(SiteLoop, PlatesThatAPanelHidesAreNotAskedFor) {
  const Program plumbline;
  Site site(plumbline);
  int round = 1;
  for (bool hangs = false; !hangs && round < 8; ++round) {
    site.measure(round);
    const Answer answer = run_round(plumbline, round);
    ASSERT_EQ(answer.code, 0) << answer.err;
    const std::string out = "round" + std::to_string(round);
    const Json state = Json::parse(read_file(plumbline.work() / out / "state.json"));
    for (const Json& item : state["items"]) hangs = hangs || (item["id"] == "F01-P01" && item["status"] == "VERIFIED");
    site.work(round);
  }
  site.measure(round, "F01-C01-R1");
  const Answer answer = run_round(plumbline, round);
  EXPECT_EQ(answer.code, 0) << answer.err;
  EXPECT_FALSE(contains(answer.out + answer.err, "Measured in part")) << answer.err;
  const std::string state = read_file(plumbline.work() / ("round" + std::to_string(round)) / "state.json");
  for (const Json& item : Json::parse(state)["items"])
    if (item["id"] == "F01-P01") {
      EXPECT_EQ(item["status"], "VERIFIED") << item["why"];
    }
}

/// Who, when, why and on what it rests: of verdicts, reports and what a person says.
TEST(SiteLoop, EveryLineOfTheJournalIsWhole) {
  const Program plumbline;
  Site site(plumbline);
  for (int round = 1; round <= 3; ++round) {
    site.measure(round);
    std::vector<std::string> more;
    if (round == 3) more = {"reported.with.moved_control=[K1]", "reported.with.by=Meier"};
    const Answer answer = run_round(plumbline, round, more);
    ASSERT_TRUE(answer.code == 0 || answer.code == 3) << answer.err;
    site.work(round);
  }
  std::set<std::string> who;
  std::istringstream journal(read_file(plumbline.work() / "round3/journal.jsonl"));
  for (std::string text; std::getline(journal, text);) {
    const Json line = Json::parse(text);
    for (const char* key : {"by", "at", "why"}) EXPECT_FALSE(line[key].get<std::string>().empty()) << text;
    ASSERT_FALSE(line["rests_on"].empty()) << text;
    for (const Json& hash : line["rests_on"]) EXPECT_EQ(hash.get<std::string>().size(), 64u) << text;
    who.insert(line["by"].get<std::string>());
  }
  EXPECT_TRUE(who.count("plumbline") && who.count("robot-1")) << "verdicts and reports";
}

/// Two foremen run the same round, each with the reports of one robot, into one folder: neither is lost.
TEST(SiteLoop, ASecondRunOfARoundLosesNoReport) {
  const Program plumbline;
  Site site(plumbline);
  site.measure(1);
  ASSERT_EQ(run_round(plumbline, 1).code, 0);
  ASSERT_GE(site.work(1), 2u);
  const Json all = Json::parse(read_file(plumbline.work() / "actuals1.json"));
  Json one, other;
  for (std::size_t i = 0; i < all["items"].size(); ++i) (i < 2 ? one : other)["items"].push_back(all["items"][i]);
  plumbline.write("one.json", one.dump()), plumbline.write("other.json", other.dump());
  site.measure(2);
  ASSERT_EQ(run_round(plumbline, 2, {"reports.with.json=[one.json]"}).code, 0);
  const fs::path journal = plumbline.work() / "round2/journal.jsonl";
  const std::string before = read_file(journal), state = read_file(plumbline.work() / "round2/state.json");
  const Answer second = run_round(plumbline, 2, {"reports.with.json=[other.json]"});
  EXPECT_EQ(second.code, 1) << second.err;
  const std::string first = one["items"][0]["item"];
  EXPECT_TRUE(contains(second.err, "has 2 reports that this run does not have: " + first + " by robot-1 at "))
      << second.err;
  EXPECT_TRUE(contains(second.err, "give both runs' reports")) << second.err;
  EXPECT_EQ(read_file(journal), before);
  EXPECT_EQ(read_file(plumbline.work() / "round2/state.json"), state) << "nor anything beside it";
  const Answer both = run_round(plumbline, 2, {"reports.with.json=[one.json, other.json]"});
  EXPECT_EQ(both.code, 0) << both.err;
  EXPECT_NE(read_file(journal), before);
}

/// Into two folders, too: a state has one round after it.
TEST(SiteLoop, AStateIsGoneOnFromOnce) {
  const Program plumbline;
  Site site(plumbline);
  site.measure(1);
  ASSERT_EQ(run_round(plumbline, 1).code, 0);
  ASSERT_GE(site.work(1), 2u);
  const Json all = Json::parse(read_file(plumbline.work() / "actuals1.json"));
  Json one, other;
  for (std::size_t i = 0; i < all["items"].size(); ++i) (i < 2 ? one : other)["items"].push_back(all["items"][i]);
  plumbline.write("one.json", one.dump()), plumbline.write("other.json", other.dump());
  site.measure(2);
  const auto second = [&](const std::string& out, const std::string& reports) {
    return run_round(plumbline, 2, {"reports.with.json=[" + reports + "]"}, out);
  };
  ASSERT_EQ(second("a", "one.json").code, 0);
  const Answer fork = second("b", "other.json");
  EXPECT_EQ(fork.code, 1) << fork.err;
  EXPECT_TRUE(contains(fork.err, "a round was already run on this state: ")) << fork.err;
  EXPECT_TRUE(contains(fork.err, "/a/state.json")) << fork.err;
  EXPECT_FALSE(fs::exists(plumbline.work() / "b/job.json"));
  EXPECT_EQ(second("a", "one.json").code, 0) << "the same once more is no other one";
  EXPECT_EQ(second("c", "one.json").code, 1) << "a copy would be gone on from by somebody else";
  const Answer both = second("a", "one.json, other.json");
  EXPECT_EQ(both.code, 0) << both.err;
  // What was gone on from is not made another one under whoever went on.
  const Answer third =
      run_round(plumbline, 3,
                {"state=a/state.json", "reports.with.json=[]", "folder=campaign2", "reported.with.moved_control=[K1]"});
  ASSERT_TRUE(third.code == 0 || third.code == 3) << third.err;
  const std::vector<std::string> other_words = {"reported.with.moved_control=[K1]",
                                                "reports.with.json=[one.json, other.json]"};
  const Answer under = run_round(plumbline, 2, other_words, "a");
  EXPECT_EQ(under.code, 1) << under.err;
  EXPECT_TRUE(contains(under.err, "goes on from, and this run gives another one")) << under.err;
  fs::remove_all(plumbline.work() / "round3");
  const Answer alone = run_round(plumbline, 2, other_words, "a");
  EXPECT_TRUE(alone.code == 0 || alone.code == 3) << alone.err;
}

}  // namespace test_site_loop
}  // namespace plumbline::test

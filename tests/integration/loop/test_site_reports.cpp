// What comes back to site_loop.yaml: staked points and reports, in the frame of the survey, right and wrong.
#include <functional>
#include <map>
#include <set>

#include "site_in_files.hpp"

namespace plumbline::test {
namespace test_site_reports {

/// Points of a layout file: PtID;E;N;H.
std::map<std::string, Eigen::Vector3d> points_of(const fs::path& file) {
  std::map<std::string, Eigen::Vector3d> points;
  std::istringstream rows(read_file(file));
  std::string row;
  std::getline(rows, row);
  while (std::getline(rows, row)) {
    std::istringstream cells(row);
    std::vector<std::string> cell(4);
    for (std::string& one : cell) std::getline(cells, one, ';');
    points[cell[0]] = {std::stod(cell[1]), std::stod(cell[2]), std::stod(cell[3])};
  }
  return points;
}

/// A tool is set up on control.csv and sets what is in layout_hilti.csv. In two frames, 50 mm or 6000 km apart, it sets
/// it there; what it stakes comes back, and the next campaign finds every bracket where it was to be.
TEST(SiteReports, ControlLayoutsAndStakedPointsAreInTheFrameOfTheSurvey) {
  for (const SurveyFrame& frame :
       {SurveyFrame{{0.030, -0.045, 0.020}, 0.5}, SurveyFrame{{500000, 5700000, 432.1}, 33}}) {
    const Program plumbline;
    Site site(plumbline, frame);
    site.measure(1);
    ASSERT_EQ(run_round(plumbline, 1, frame.words()).code, 0);
    const auto layout = points_of(plumbline.work() / "round1/layout_hilti.csv");
    ASSERT_FALSE(layout.empty());
    std::map<std::string, Eigen::Vector3d> before;
    for (const auto& [name, place] : layout) before[name] = site.place(name);
    site.work(1);  // along each bracket's own axes, whatever the frame
    for (const auto& [name, place] : layout) {
      EXPECT_LT((place - site.place(name)).norm(), 0.0015) << name << ": stakes and settings say the same";
      EXPECT_LT((place - before[name]).norm(), 0.03) << name;
    }
    const Json job = Json::parse(read_file(plumbline.work() / "round1/job.json"));
    EXPECT_EQ(job["frames"][0]["name"], "survey");
    EXPECT_NEAR(std::sqrt(job["frames"][0]["buildingFromFrame"]["covariance"][14].get<double>()), 0.0005, 1e-6);
    std::string staked = "PtID;E;N;H;Timestamp\n";
    for (const auto& [name, place] : layout) {
      char text[200];
      const Eigen::Vector3d p = site.place(name);
      std::snprintf(text, sizeof text, "%s;%.4f;%.4f;%.4f;%s\n", name.c_str(), p.x(), p.y(), p.z(),
                    day(2, "06:00").c_str());
      staked += text;
    }
    plumbline.write("staked.csv", staked);
    site.measure(2);
    std::vector<std::string> words = frame.words();
    words.push_back("reports.with.hilti=[staked.csv]"), words.push_back("reports.with.json=[]");
    const Answer second = run_round(plumbline, 2, words);
    ASSERT_EQ(second.code, 0) << second.out << second.err;
    const std::string summary = read_file(plumbline.work() / "round2/summary.txt");
    EXPECT_FALSE(contains(summary, "not taken")) << summary;
    EXPECT_TRUE(contains(summary, "floor 1: hang ")) << summary;
  }
}

/// Reports of robots in that frame, until every panel hangs.
TEST(SiteReports, InAMapRoundAfterRoundUntilEveryPanelHangs) {
  const Program plumbline;
  const SurveyFrame map{{500000, 5700000, 432.1}, 33};
  Site site(plumbline, map);
  std::string summary;
  for (int round = 1; round < 16; ++round) {
    site.measure(round);
    const Answer answer = run_round(plumbline, round, map.words());
    ASSERT_EQ(answer.code, 0) << answer.out << answer.err;
    summary = read_file(plumbline.work() / ("round" + std::to_string(round)) / "summary.txt");
    EXPECT_FALSE(contains(summary, "not taken")) << summary;
    if (contains(summary, "next: nothing: every panel hangs")) break;
    site.work(round);
  }
  EXPECT_TRUE(contains(summary, "next: nothing: every panel hangs within its limits")) << summary;
}

TEST(SiteReports, WhatARoundMustKnowIsAskedFor) {
  const Program plumbline;
  Site site(plumbline);
  site.measure(1);
  const Answer both = run_round(plumbline, 1, {"first=false"});
  EXPECT_EQ(both.code, 1);
  EXPECT_TRUE(contains(both.err, "no state is given: state=FOLDER/state.json of the round before")) << both.err;
  ASSERT_EQ(run_round(plumbline, 1).code, 0);
  ASSERT_GT(site.work(1), 0u);
  // A state that somebody edited.
  std::string state = read_file(plumbline.work() / "round1/state.json");
  state.replace(state.find("\"RELEASED\""), 10, "\"VERIFIED\"");
  plumbline.write("round1/edited.json", state);
  site.measure(2);
  const Answer edited = run_round(plumbline, 2, {"state=round1/edited.json"});
  EXPECT_EQ(edited.code, 1);
  EXPECT_TRUE(contains(edited.err, "was changed since it was written")) << edited.err;
  // The campaign of the day before: measured before the work, so nothing is verified by it.
  const Answer old = run_round(plumbline, 2, {"measured=" + day(2, "05:00")});
  ASSERT_EQ(old.code, 0) << old.err;
  const Json job = Json::parse(read_file(plumbline.work() / "round1/job.json"));
  const Json after = Json::parse(read_file(plumbline.work() / "round2/state.json"));
  for (const Json& done : job["items"])
    for (const Json& item : after["items"])
      if (item["id"] == done["id"]) {
        EXPECT_EQ(item["status"], "EXECUTED") << item["why"];
        EXPECT_EQ(item["why"], "waits for a measurement that was made after it was done");
      }
}

/// Work that was done and reported wrongly: named, nothing lost, and nothing that was asked for then is VERIFIED.
TEST(SiteReports, WrongReportsAreNamedAndVerifyNothing) {
  const Program plumbline;
  Site site(plumbline);
  site.measure(1);
  ASSERT_EQ(run_round(plumbline, 1).code, 0);
  ASSERT_GT(site.work(1), 0u);
  site.measure(2);
  const Json job = Json::parse(read_file(plumbline.work() / "round1/job.json"));
  const Json right = Json::parse(read_file(plumbline.work() / "actuals1.json"));
  std::map<std::string, Json> target;
  std::set<std::string> moved;
  for (const Json& item : job["items"]) {
    target[item["id"]] = item["targetPose"]["position"];
    // What was asked to move by less than the survey can tell may be found to need no setting, whatever is reported.
    double asked = 0;
    for (const Json& along : item["setting"]) asked = std::max(asked, std::abs(along.get<double>()));
    if (asked > 0.001) moved.insert(item["id"]);
  }
  ASSERT_GE(moved.size(), 4u);
  const std::map<std::string, std::pair<std::function<void(Json&)>, std::string>> mistakes = {
      {"feet",
       {[&](Json& r) {
          for (const Json& x : target[r["item"]]) r["measured"].push_back(x.get<double>() / 0.3048);
        },
        "that would fit if it is in feet; export metres in the survey's frame"}},
      {"axes",
       {[&](Json& r) {
          const Json& p = target[r["item"]];
          r["measured"] = {p[1], p[0], p[2]};
        },
        "axes are exchanged; export metres in the survey's frame"}},
      {"frame",
       {[&](Json& r) {
          const Json& p = target[r["item"]];
          r["measured"] = {p[0].get<double>() + 400, p[1], p[2]};
        },
        "in another frame, or of another item; export metres in the survey's frame"}},
      {"early", {[](Json& r) { r["at"] = day(1, "15:00"); }, "not after the item was released"}},
      {"future", {[](Json& r) { r["at"] = day(3, "06:00"); }, "later than this round"}},
      {"none", {[](Json& r) { r["revision"] = 0; }, "expected that of the job, 1 or more"}},
      {"sigma",
       {[](Json& r) {
          r["sigma"] = {1.0, 1.0, 0.7};
        },
        "that would fit if it is in millimetres"}},
      {"revision", {[](Json& r) { r["revision"] = 7; }, "a job that is no longer valid was executed"}},
      {"job", {[](Json& r) { r["job"] = "job-of-another-site"; }, "another job was executed"}},
      {"name", {[](Json& r) { r["item"] = r["item"].get<std::string>() + "x"; }, "no bracket or panel of this name"}}};
  for (const auto& [name, mistake] : mistakes) {
    Json wrong = right;
    for (Json& report : wrong["items"]) mistake.first(report);
    plumbline.write(name + ".json", wrong.dump());
    const Answer answer = run_round(plumbline, 2, {"reports.with.json=[" + name + ".json]"});
    ASSERT_EQ(answer.code, 0) << name << answer.err;
    const std::string told = answer.out + answer.err;
    EXPECT_TRUE(contains(told, mistake.second)) << name << answer.err;
    const auto says = [&](const char* what_to_do) { return contains(told, what_to_do); };
    EXPECT_TRUE(name == "none" || says("report it again") || says("measure the item") || says("export metres"))
        << name << " does not say what to do: " << answer.err;
    const Json state = Json::parse(read_file(plumbline.work() / "round2/state.json"));
    for (const Json& item : state["items"])
      if (moved.count(item["id"])) {
        EXPECT_NE(item["status"], "VERIFIED") << name << " " << item["id"] << item["why"];
      }
  }
}

}  // namespace test_site_reports
}  // namespace plumbline::test

// site_loop.yaml as a site runs it: a folder for each campaign, reports as files, a state from round to round, until
// every panel hangs. The site is simulated here, and goes in as files only.
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "geometry/random.hpp"
#include "loop/job/job.hpp"
#include "program.hpp"
#include "test_paths.hpp"

namespace plumbline::test {
namespace site_loop_test {

using Json = nlohmann::json;
namespace fs = std::filesystem;

constexpr const char* kStart = R"(plumbline: 1
nodes:
  start: {use: simulate.campaign, with: {floors: 2, columns: 3, photographs: observed}}
outputs: {site: start.folder, truth: start.truth}
)";

/// Truth in, readings of a total station out, as the file that a surveyor brings.
constexpr const char* kMeasure = R"(plumbline: 1
vars: {truth: ~}
nodes:
  truth: {use: read.points, with: {file: "${truth}"}}
  site: {use: simulate.site, in: {truth: truth.points}}
  readings: {use: simulate.survey, in: {markers: site.markers, set_ups: site.set_ups}, with: {sets: 8}}
  file: {use: write.survey_csv, in: {observations: readings.observations}}
outputs: {readings.csv: file.file, control.json: site.control}
)";

std::string day(int number, const char* time) {
  char text[40];
  std::snprintf(text, sizeof text, "2026-05-%02dT%s:00Z", number, time);
  return text;
}

/// Where hooks are, and robots that do what a job says to a tenth of a millimetre.
class Site {
 public:
  explicit Site(const Program& plumbline) : plumbline_(plumbline) {
    plumbline.write("start.yaml", kStart), plumbline.write("measure.yaml", kMeasure);
    const Answer answer = plumbline({"run", "start.yaml", "--out", "start", "seed=3"});
    if (answer.code != 0) throw std::runtime_error(answer.err);
    std::istringstream rows(read_file(plumbline.work() / "start/truth/anchors.csv"));
    std::string row;
    std::getline(rows, head_);
    while (std::getline(rows, row))
      if (!row.empty()) truth_.push_back(row);
  }

  /// A campaign folder of what stands now.
  void measure(int round) {
    std::string table = "id,E,N,H\n";
    for (const std::string& row : truth_) {
      const auto [name, place] = read(row);
      char text[200];
      std::snprintf(text, sizeof text, "%s,%.6f,%.6f,%.6f\n", name.c_str(), place.x(), place.y(), place.z());
      table += text;
    }
    plumbline_.write("truth.csv", table);
    const std::string out = "measured" + std::to_string(round), folder = "campaign" + std::to_string(round);
    const Answer answer =
        plumbline_({"run", "measure.yaml", "--out", out, "truth=truth.csv", "seed=" + std::to_string(round)});
    if (answer.code != 0) throw std::runtime_error(answer.err);
    fs::create_directory(plumbline_.work() / folder);
    for (const char* name : {"plates.csv", "design.ifc"})
      fs::copy_file(plumbline_.work() / "start/site" / name, plumbline_.work() / folder / name);
    fs::copy_file(plumbline_.work() / out / "readings.csv", plumbline_.work() / folder / "readings.csv");
    std::string control = "id,E,N,H,sE_mm,sN_mm,sH_mm\n";
    const Json marks = Json::parse(read_file(plumbline_.work() / out / "control.json"));
    for (const Json& point : marks["points"]) {
      const Json& p = point["position"];
      char text[200];
      std::snprintf(text, sizeof text, "%s,%.6f,%.6f,%.6f,0.3,0.3,0.3\n", point["id"].get<std::string>().c_str(),
                    p[0].get<double>(), p[1].get<double>(), p[2].get<double>());
      control += text;
    }
    plumbline_.write(folder + "/control.csv", control);
    plumbline_.write(folder + "/campaign.yaml",
                     "plumbline_campaign: 1\nsurvey: readings.csv\nplates: plates.csv\ndesign: design.ifc\ncontrol: "
                     "control.csv\ndate: 2026-05-01\n");
  }

  /// Does the job of a round, and reports it the day after. Returns the number of items.
  std::size_t work(int round) {
    const loop::Job job = loop::read_job(read_file(plumbline_.work() / ("round" + std::to_string(round)) / "job.json"));
    Random luck(7, "robot", static_cast<std::uint64_t>(round));
    Json reports;
    reports["items"] = Json::array();
    for (const loop::JobItem& item : job.items) {
      Json report{{"item", item.id},
                  {"job", job.id},
                  {"revision", item.revision},
                  {"by", "robot-1"},
                  {"at", day(round + 1, "06:00")},
                  {"outcome", "done"}};
      if (item.kind == "bracket")
        move(item.id, item.design_rotation * (item.setting + luck.normal3(0.0001)));
      else
        for (int k = 0; k < 3; ++k) report["measured"].push_back(job.origin[k] + item.target[k] + luck.normal(0.001));
      reports["items"].push_back(report);
    }
    plumbline_.write("actuals" + std::to_string(round) + ".json", reports.dump());
    return job.items.size();
  }

  void move(const std::string& name, const Eigen::Vector3d& by) {
    for (std::string& row : truth_) {
      auto [id, place] = read(row);
      if (id != name) continue;
      place += by;
      char text[200];
      std::snprintf(text, sizeof text, "%s,%.6f,%.6f,%.6f", id.c_str(), place.x(), place.y(), place.z());
      row = text;
    }
  }

  std::vector<std::string> names() const {
    std::vector<std::string> all;
    for (const std::string& row : truth_) all.push_back(read(row).first);
    return all;
  }

 private:
  /// Of a row of truth/anchors.csv, or one of ours.
  std::pair<std::string, Eigen::Vector3d> read(const std::string& row) const {
    std::vector<std::string> cells;
    std::istringstream stream(row);
    for (std::string cell; std::getline(stream, cell, ',');) cells.push_back(cell);
    const std::size_t first = cells.size() > 4 ? 8 : 1;  // x_m, y_m, z_m
    return {cells.at(0), {std::stod(cells[first]), std::stod(cells[first + 1]), std::stod(cells[first + 2])}};
  }

  const Program& plumbline_;
  std::string head_;
  std::vector<std::string> truth_;
};

Answer run_round(const Program& plumbline, int round, std::vector<std::string> more = {}) {
  const std::string number = std::to_string(round), before = std::to_string(round - 1);
  std::vector<std::string> words = {"run",
                                    std::string(source_dir()) + "/pipelines/site_loop.yaml",
                                    "--out",
                                    "round" + number,
                                    "folder=campaign" + number,
                                    "now=" + day(round, "16:00"),
                                    "measured=" + day(round, "09:00"),
                                    R"(plan.with.brackets=["*: right=20mm, up=15mm, out=25mm"])",
                                    "mounting_sigma=0"};
  if (round == 1)
    words.push_back("first=true");
  else
    words.insert(words.end(),
                 {"state=round" + before + "/state.json", "reports.with.json=[actuals" + before + ".json]"});
  words.insert(words.end(), more.begin(), more.end());
  return plumbline(words);
}

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

TEST(SiteLoop, WhatARoundMustKnowIsAskedFor) {
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
TEST(SiteLoop, WrongReportsAreNamedAndVerifyNothing) {
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
        "that would fit if it is in feet"}},
      {"axes",
       {[&](Json& r) {
          const Json& p = target[r["item"]];
          r["measured"] = {p[1], p[0], p[2]};
        },
        "axes are exchanged"}},
      {"frame",
       {[&](Json& r) {
          const Json& p = target[r["item"]];
          r["measured"] = {p[0].get<double>() + 400, p[1], p[2]};
        },
        "in another frame"}},
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
    EXPECT_TRUE(contains(answer.out + answer.err, mistake.second)) << name << answer.err;
    const Json state = Json::parse(read_file(plumbline.work() / "round2/state.json"));
    for (const Json& item : state["items"])
      if (moved.count(item["id"])) {
        EXPECT_NE(item["status"], "VERIFIED") << name << " " << item["id"] << item["why"];
      }
  }
}

}  // namespace site_loop_test
}  // namespace plumbline::test

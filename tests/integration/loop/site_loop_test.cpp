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

/// How the design lies in the survey: where its origin is, and by how much it is turned.
struct SurveyFrame {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  double degrees = 0;

  double angle() const { return degrees * 3.14159265358979323846 / 180; }
  Eigen::Matrix3d turn() const { return Eigen::AngleAxisd(angle(), Eigen::Vector3d::UnitZ()).toRotationMatrix(); }
  Eigen::Vector3d survey(const Eigen::Vector3d& building) const { return origin + turn() * building; }
  Eigen::Vector3d building(const Eigen::Vector3d& survey) const { return turn().transpose() * (survey - origin); }
  std::vector<std::string> words() const {
    char text[200];
    std::snprintf(text, sizeof text, "frames.with.translation=[%.4f, %.4f, %.4f]", origin.x(), origin.y(), origin.z());
    return {"frames.with.use=given", text, "frames.with.rotation=" + std::to_string(angle()),
            "frames.with.sigmas=[0.00001, 0.0005, 0.0005, 0.0005]"};
  }
};

/// Where hooks are, and robots that do what a job says to a tenth of a millimetre.
class Site {
 public:
  explicit Site(const Program& plumbline, SurveyFrame frame = {}) : plumbline_(plumbline), frame_(frame) {
    plumbline.write("start.yaml", kStart), plumbline.write("measure.yaml", kMeasure);
    const Answer answer = plumbline({"run", "start.yaml", "--out", "start", "seed=3"});
    if (answer.code != 0) throw std::runtime_error(answer.err);
    std::istringstream rows(read_file(plumbline.work() / "start/truth/anchors.csv"));
    std::string row;
    std::getline(rows, head_);
    while (std::getline(rows, row))
      if (!row.empty()) truth_.push_back(row);
  }

  /// A campaign folder of what stands now; anchors whose name begins with `but` are not measured.
  void measure(int round, const std::string& but = "none") {
    std::string table = "id,E,N,H\n";
    for (const std::string& row : truth_) {
      const auto [name, place] = read(row);
      if (name.rfind(but, 0) == 0) continue;
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
    fs::copy_file(plumbline_.work() / "start/site/design.ifc", plumbline_.work() / folder / "design.ifc");
    plumbline_.write(folder + "/plates.csv", turned_plates());
    fs::copy_file(plumbline_.work() / out / "readings.csv", plumbline_.work() / folder / "readings.csv");
    std::string control = "id,E,N,H,sE_mm,sN_mm,sH_mm\n";
    const Json marks = Json::parse(read_file(plumbline_.work() / out / "control.json"));
    for (const Json& point : marks["points"]) {
      const Json& given = point["position"];
      const Eigen::Vector3d p = frame_.survey({given[0].get<double>(), given[1].get<double>(), given[2].get<double>()});
      char text[200];
      std::snprintf(text, sizeof text, "%s,%.6f,%.6f,%.6f,0.3,0.3,0.3\n", point["id"].get<std::string>().c_str(), p.x(),
                    p.y(), p.z());
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
    if (job.frame != (frame_.degrees == 0 ? "building" : "survey")) throw std::runtime_error("a job in " + job.frame);
    Random luck(7, "robot", static_cast<std::uint64_t>(round));
    Json reports;
    reports["items"] = Json::array();
    for (const loop::JobItem& item : job.items) {
      Json report{{"item", item.id},
                  {"job", job.id},
                  {"revision", item.revision},
                  {"by", "robot-1"},
                  {"at", day(round + 1, "06:00")},
                  {"frame", job.frame},
                  {"outcome", "done"}};
      if (item.kind == "bracket")
        move(item.id, frame_.turn().transpose() * (item.design_rotation * (item.setting + luck.normal3(0.0001))));
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

  /// Where the hook of a bracket is, in the frame of the survey.
  Eigen::Vector3d place(const std::string& name) const {
    for (const std::string& row : truth_)
      if (const auto [id, place] = read(row); id == name) return frame_.survey(place);
    throw std::runtime_error(name + " is no anchor");
  }

  std::vector<std::string> names() const {
    std::vector<std::string> all;
    for (const std::string& row : truth_) all.push_back(read(row).first);
    return all;
  }

 private:
  /// Azimuths of plates count from the north of the survey.
  std::string turned_plates() const {
    std::istringstream rows(read_file(plumbline_.work() / "start/site/plates.csv"));
    std::string text, row;
    std::getline(rows, row);
    std::istringstream heads(row);
    std::size_t column = 0;
    for (std::string head; std::getline(heads, head, ',') && head != "facing_azimuth_deg";) ++column;
    text = row + "\n";
    while (std::getline(rows, row)) {
      std::istringstream cells(row);
      std::size_t at = 0;
      for (std::string cell; std::getline(cells, cell, ','); ++at)
        text += (at > 0 ? "," : "") + (at == column ? std::to_string(std::stod(cell) - frame_.degrees) : cell);
      text += "\n";
    }
    return text;
  }

  /// Of a row of truth/anchors.csv, or one of ours.
  std::pair<std::string, Eigen::Vector3d> read(const std::string& row) const {
    std::vector<std::string> cells;
    std::istringstream stream(row);
    for (std::string cell; std::getline(stream, cell, ',');) cells.push_back(cell);
    const std::size_t first = cells.size() > 4 ? 8 : 1;  // x_m, y_m, z_m
    return {cells.at(0), {std::stod(cells[first]), std::stod(cells[first + 1]), std::stod(cells[first + 2])}};
  }

  const Program& plumbline_;
  SurveyFrame frame_;
  std::string head_;
  std::vector<std::string> truth_;
};

Answer run_round(const Program& plumbline, int round, std::vector<std::string> more = {}, const std::string& out = {}) {
  const std::string number = std::to_string(round), before = std::to_string(round - 1);
  std::vector<std::string> words = {"run",
                                    std::string(source_dir()) + "/pipelines/site_loop.yaml",
                                    "--out",
                                    out.empty() ? "round" + number : out,
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
TEST(SiteLoop, ControlLayoutsAndStakedPointsAreInTheFrameOfTheSurvey) {
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
TEST(SiteLoop, InAMapRoundAfterRoundUntilEveryPanelHangs) {
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

}  // namespace site_loop_test
}  // namespace plumbline::test

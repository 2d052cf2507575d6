// What nodes of the loop and the program that speaks to robots say, and what they refuse.
#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <fstream>
#include <map>
#include <set>

#include "artifacts/actuals.hpp"
#include "artifacts/file.hpp"
#include "artifacts/frame_artifact.hpp"
#include "artifacts/installation_plan.hpp"
#include "artifacts/loop_state.hpp"
#include "artifacts/points.hpp"
#include "artifacts/survey_observations.hpp"
#include "artifacts/transform.hpp"
#include "loop/job/job.hpp"
#include "loop/job/layout_files.hpp"
#include "loop/state/machine.hpp"
#include "loop/state/plan_artifact.hpp"
#include "node_harness.hpp"
#include "random_facade.hpp"
#include "released.hpp"
#include "stopping.hpp"

namespace test_nodes {

using namespace plumbline;
using namespace plumbline::loop;
using plumbline::test::NodeFailed;
using plumbline::test::NodeHarness, plumbline::test::Released;

std::string text_of(const FileT& file) { return {file.content.begin(), file.content.end()}; }

std::string said_of(NodeHarness& node) {
  try {
    node.run();
  } catch (const NodeFailed& error) {
    return error.what();
  }
  return "";
}

TEST(WriteJob, DatesThatRobotsWouldRefuseAreRefusedBeforeTheJobIsOut) {
  const Released released;
  const auto said = [&](const std::string& created, const std::string& until, std::string* job = nullptr) {
    NodeHarness node("write.job");
    node.input<InstallationPlan>("plan", released.plan), node.input<LoopState>("state", released.state);
    node.set("created_at", created), node.set("valid_until", until);
    const std::string words = said_of(node);
    if (job) *job = text_of(node.output<File>("job"));
    return words;
  };
  std::string job;
  EXPECT_EQ(said("2026-05-02T08:00:00Z", "2026-05-02T10:00:01+02:00", &job), "");
  EXPECT_EQ(read_job(job).valid_until, "2026-05-02T10:00:01+02:00");
  EXPECT_NE(said("2026-05-02T08:00:00Z", "2026-05-02T10:00:00+02:00").find("every robot would refuse it"),
            std::string::npos);
  EXPECT_NE(said("", "3.5.2026").find("valid_until is '3.5.2026'; expected ISO 8601 with a zone"), std::string::npos);
  EXPECT_NE(said("2026-05-02T08:00:00", "").find("created_at is '2026-05-02T08:00:00'; expected"), std::string::npos);
}

/// Who sets by hand sets what stands there: what waits or was recalled is in the plan, and in no file of the job.
TEST(WriteJob, SettingsByHandAreThoseOfTheJob) {
  Released released;
  std::set<std::string> asked;
  for (auto& item : released.state.items)
    if (item->kind == "bracket" && item->status == ItemStatus::released) asked.insert(item->id);
  ASSERT_GT(asked.size(), 1u);
  for (auto& item : released.state.items)
    if (item->id == *asked.begin()) item->status = ItemStatus::planned;
  NodeHarness node("write.job");
  node.input<InstallationPlan>("plan", released.plan), node.input<LoopState>("state", released.state);
  node.run();
  const std::string rows = text_of(node.output<File>("settings"));
  EXPECT_EQ(rows.find(*asked.begin() + ";"), std::string::npos) << rows;
  EXPECT_NE(rows.find(*asked.rbegin() + ";"), std::string::npos) << rows;
  EXPECT_EQ(std::count(rows.begin(), rows.end(), '\n'), static_cast<std::ptrdiff_t>(asked.size())) << rows;
}

/// A survey that is shifted by millimetres looks like no other frame, and is one.
/// The job is refused after that, and the state would say that it is out.
TEST(ReleaseState, NothingIsReleasedForAJobThatIsOver) {
  const Released released;
  const auto said = [&](const std::string& until) {
    NodeHarness node("release.state");
    node.input<InstallationPlan>("plan", released.plan), node.input<LoopState>("state", LoopStateT());
    node.set("released_at", "2026-05-02T08:00:00Z"), node.set("valid_until", until);
    return said_of(node);
  };
  EXPECT_EQ(said("2026-05-02T10:00:01+02:00"), "");
  EXPECT_NE(said("2026-05-02T10:00:00+02:00").find("every robot would refuse it; nothing is released"),
            std::string::npos);
  EXPECT_NE(said("tomorrow").find("valid_until is 'tomorrow'; expected ISO 8601"), std::string::npos);
}

/// Whole sites are released in a moment, and what asks there must be told.
TEST(ReleaseState, CanBeStopped) {
  const Released released;
  EXPECT_EQ(test::stopping_at_fault([&] {
              NodeHarness node("release.state");
              node.input<InstallationPlan>("plan", released.plan), node.input<LoopState>("state", LoopStateT());
              return node;
            }),
            "");
}

TEST(WriteJob, HandsOutWhatIsWhereTheControlIs) {
  const Released released;
  FrameLink link;
  link.to = "building", link.from = "survey", link.plan_only = true;
  link.to_from_from.translation = {0.030, -0.045, 0.020};
  PointsT control;
  control.points.push_back(std::make_unique<PointT>());
  control.points[0]->id = "G1", control.points[0]->role = "control";
  control.points[0]->position = {-4, -8, 1}, control.points[0]->sigma.setConstant(0.0005);
  const auto outputs = [&](const FrameLink* applied) {
    NodeHarness node("write.job");
    node.input<InstallationPlan>("plan", released.plan), node.input<LoopState>("state", released.state);
    node.input<Points>("control", control);
    if (applied) node.input<Transform>("frames", transform_artifact(*applied));
    node.run();
    return std::array{text_of(node.output<File>("job")), text_of(node.output<File>("hilti")),
                      text_of(node.output<File>("control_points"))};
  };
  const auto designed = outputs(nullptr), turned = outputs(&link);
  EXPECT_EQ(designed[2], turned[2]) << "as it was given";
  const auto first = [](const std::string& layout) {
    return read_staked(layout, LayoutFormat::hilti, "layout").items.at(0)->measured;
  };
  EXPECT_LT((first(designed[1]) - first(turned[1]) - link.to_from_from.translation).norm(), 2e-4);
  EXPECT_EQ(read_job(designed[0]).frame, "building");
  EXPECT_EQ(read_job(turned[0]).frame, "survey");
  EXPECT_EQ(read_job(turned[0]).id, read_job(designed[0]).id);
  link.plan_only = false, link.to_from_from.rotation = Eigen::AngleAxisd(0.002, Eigen::Vector3d::UnitX());
  NodeHarness node("write.job");
  node.input<InstallationPlan>("plan", released.plan), node.input<LoopState>("state", released.state);
  node.input<Transform>("frames", transform_artifact(link));
  EXPECT_NE(said_of(node).find("mm per metre against the design"), std::string::npos) << said_of(node);
}

TEST(ReadActuals, WhatIsNotReadIsSaid) {
  FileT file;
  file.name = "actuals.json", file.media_type = "application/json";
  const std::string text =
      R"({"items": [{"item": "A", "outcome": "done", "torque": 4}, {"item": "B", "otcome": "done"}]})";
  file.content.assign(text.begin(), text.end());
  NodeHarness node("read.actuals");
  node.input<File>("file", file), node.run();
  ASSERT_EQ(node.warnings().size(), 2U);
  EXPECT_EQ(node.warnings()[0], "actuals.json: items[1]: has 'otcome', which is no key; 'outcome' is");
  EXPECT_EQ(node.warnings()[1], "actuals.json: 'torque' is not read");
  EXPECT_EQ(node.metric("reports"), 1);
  EXPECT_EQ(node.output<Actuals>("actuals").items.at(0)->item, "A");
}

TEST(SimulateSite, AKnockedMarkIsElsewhereThanItIsKnown) {
  PointsT truth;
  for (double x : {0.0, 6.0})
    for (double z : {3.0, 6.0}) {
      auto point = std::make_unique<PointT>();
      point->id = "A" + std::to_string(truth.points.size()), point->position = Eigen::Vector3d(x, 10, z);
      point->sigma.setZero();
      truth.points.push_back(std::move(point));
    }
  NodeHarness node("simulate.site");
  node.input<Points>("truth", truth), node.set("knocked", "K2"), node.run();
  const PointsT real = node.output<Points>("markers"), known = node.output<Points>("control");
  ASSERT_EQ(known.points.size(), 6U);
  for (const auto& mark : known.points)
    for (const auto& point : real.points) {
      if (point->id != mark->id) continue;
      const Eigen::Vector3d off = point->position - mark->position;
      EXPECT_NEAR(off.z(), mark->id == "K2" ? 0.006 : 0, 1e-12) << mark->id;
      EXPECT_LT(off.head<2>().norm(), 1e-12) << mark->id;
    }
  node.set("knocked", "K7");
  EXPECT_NE(said_of(node).find("'knocked' names K7, and the control marks are K1 to K6"), std::string::npos);
}

PointsT four_hooks() {
  PointsT truth;
  for (double x : {0.0, 6.0})
    for (double z : {3.0, 6.0}) {
      auto point = std::make_unique<PointT>();
      point->id = "A" + std::to_string(truth.points.size()), point->position = Eigen::Vector3d(x, 10, z);
      point->sigma.setZero();
      truth.points.push_back(std::move(point));
    }
  return truth;
}

/// How far each point is from where it should be, by id, in a round of a loop.
std::map<std::string, Eigen::Vector3d> off_in_round(int round, const std::map<std::string, std::string>& words) {
  NodeHarness node("simulate.site");
  const PointsT hooks = four_hooks();
  LoopStateT state;
  state.round = round;
  node.input<Points>("truth", hooks), node.input<LoopState>("state", state);
  for (const auto& [name, value] : words) node.set(name, value);
  node.seed(static_cast<std::uint64_t>(round) + 1), node.run();
  const PointsT real = node.output<Points>("markers"), known = node.output<Points>("control");
  std::map<std::string, Eigen::Vector3d> off;
  for (const auto& point : real.points)
    for (const PointsT* ideal : {&hooks, &known})
      for (const auto& there : ideal->points)
        if (there->id == point->id) off[point->id] = point->position - there->position;
  return off;
}

/// While the loop runs, and from then on.
TEST(SimulateSite, MarksAndPlatesAreKnockedWhileTheLoopRuns) {
  for (const int round : {0, 1, 2, 3}) {
    const auto named = off_in_round(round, {{"knocked", "K2"}, {"knocked_from", "2"}});
    EXPECT_NEAR(named.at("K2").z(), round >= 2 ? 0.006 : 0, 1e-12) << round;
    EXPECT_LT(named.at("K1").norm(), 1e-12);
    EXPECT_LT(named.at("A0").norm(), 1e-12) << "a plate";
  }
  std::set<std::string> knocked, bumped;
  for (int round = 0; round < 12; ++round) {
    const auto off = off_in_round(round, {{"knock_share", "0.2"}, {"bump_share", "0.2"}});
    for (const auto& [id, by] : off) {
      auto& known = id[0] == 'K' ? knocked : bumped;
      if (known.count(id) > 0) {
        EXPECT_GT(by.norm(), 0.004) << id << " stays so";
      }
      if (by.norm() > 1e-12) {
        EXPECT_NEAR(by.norm(), id[0] == 'K' ? 0.006 : 0.005, 1e-12);
        known.insert(id);
      }
    }
  }
  EXPECT_GE(knocked.size(), 2u);
  EXPECT_GE(bumped.size(), 2u);
}

struct Ended {
  int code = -1;
  std::string said;
};

Ended robots(const std::string& words) {
  Ended ended;
  FILE* pipe = popen((std::string(PLUMBLINE_ROBOTS) + " " + words + " 2>&1").c_str(), "r");
  char part[512];
  while (pipe && fgets(part, sizeof part, pipe)) ended.said += part;
  const int status = pipe ? pclose(pipe) : -1;
  ended.code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return ended;
}

/// Before any broker is asked.
TEST(Robots, WhatCannotBeCarriedOutIsSaidWithItsCode) {
  const std::string folder = ::testing::TempDir() + "/plumbline_robots_words";
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  const auto write = [&](const std::string& name, const std::string& text) {
    std::ofstream(folder + "/" + name, std::ios::binary) << text;
    return folder + "/" + name;
  };
  const Released released;
  const std::string job = write("job.json", job_json(make_job(released.plan, released.state, 0, "", "")));
  const std::string common = " --folder " + folder + "/spool --longest 1 --port 1 ";
  const auto expect = [&](const std::string& words, int code, const std::string& said) {
    const Ended ended = robots(words + common);
    EXPECT_EQ(ended.code, code) << words << "\n" << ended.said;
    EXPECT_NE(ended.said.find(said), std::string::npos) << words << "\n" << ended.said;
  };
  expect("--job " + job + " --robot Acme", 1, "--robot is 'Acme'; expected MANUFACTURER/SERIAL-NUMBER");
  expect("--job " + job + " --robot 'Acme/R 2'", 1, "serial number is 'R 2'");
  expect("--job " + job + " --robot Acme/R2 --version 1.1", 2, "--version");
  expect("--robot Acme/R2", 2, "--job");
  expect("--job " + folder + "/none.json --robot Acme/R2", 1, "cannot read " + folder + "/none.json");
  expect("--job " + write("torn.json", "{\"jobId\": ") + " --robot Acme/R2", 1, "torn.json: job: the file is no JSON");
  expect("--job " +
             write("late.json", job_json(make_job(released.plan, released.state, 0, "", "2020-01-01T00:00:00Z"))) +
             " --robot Acme/R2",
         3, "was valid until 2020-01-01T00:00:00Z");
  expect("--job " + job + " --robot Acme/R2 --public-key " + write("key.pem", "none"), 1,
         "cannot read " + job + ".sig");
  write("job.json.sig", std::string(64, 'x'));
  expect("--job " + job + " --robot Acme/R2 --public-key " + folder + "/key.pem", 1, "no Ed25519 public key in PEM");
  expect("--job " + job + " --robot Acme/R2 --host 192.0.2.1", 1, "give --ca");
  // A broker that is not there: not an error, and not the end of the job.
  const Ended away = robots("--job " + job + " --robot Acme/R2" + common);
  EXPECT_EQ(away.code, 3) << away.said;
  EXPECT_NE(away.said.find("start again with the same words to go on"), std::string::npos) << away.said;
}

}  // namespace test_nodes

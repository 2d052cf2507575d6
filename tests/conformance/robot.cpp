// What every model of a robot must do: work on what the job names and on nothing else, about as far as it asks, and
// report on each item once.
#include <algorithm>
#include <cmath>
#include <map>

#include "artifacts/actuals.hpp"
#include "artifacts/file.hpp"
#include "artifacts/installation_plan.hpp"
#include "artifacts/points.hpp"
#include "node_harness.hpp"
#include "parameter_effects.hpp"

namespace robot_tests {

using namespace plumbline;
using namespace plumbline::test;
using Eigen::Vector3d;

std::string pose(const std::string& place) {
  // right, up, out of a facade that faces -y: a quarter turn about x.
  return R"({"position": [)" + place + R"(], "orientation": [0.707106781186547524, 0, 0, 0.707106781186547524]})";
}

/// Two brackets, moved by 4 mm up and 6 mm out, and by 3 mm to the left, and a panel.
FileT make_job(bool empty = false) {
  const auto item = [](const std::string& id, const std::string& more, const std::string& design,
                       const std::string& target) {
    return R"({"id": ")" + id +
           R"(", "storey": 1, "revision": 2, "dependsOn": [], "frame": "building", "designPose": )" + pose(design) +
           R"(, "targetPose": )" + pose(target) +
           R"(, "toleranceZone": {"right": 0.003, "up": 0.003, "out": 0.003}, "gate": {"verdict": "GO", )"
           R"("reason": "p 0.99", "probability": 0.99}, )" +
           more + "}";
  };
  const std::string bracket = R"("kind": "bracket", "operation": "setBracket", "setting": )";
  const std::string items =
      item("b0", bracket + R"({"right": 0, "up": 0.004, "out": 0.006})", "0, 0, 0", "0, -0.006, 0.004") + ", " +
      item("b1", bracket + R"({"right": -0.003, "up": 0, "out": 0})", "2, 0, 0", "1.997, 0, 0") + ", " +
      item("p0", R"("kind": "panel", "operation": "placePanel")", "1, 0, -1", "1, 0, -1");
  std::string identity = "1e-6";
  for (int i = 1; i < 36; ++i) identity += i % 7 == 0 ? ", 1e-6" : ", 0";
  const std::string text =
      R"({"jobId": "job-1", "revision": 2, "units": {"length": "m", "angle": "rad"}, "sources": {"basis": "abc"}, )"
      R"("frames": [{"name": "building", "origin": [100, 200, 30], "orientation": [0, 0, 0, 1], )"
      R"("robotInFrameCovariance": [)" +
      identity + R"(]}], "assumedRobot": {"settingSigma": 0.0005, "stationSigma": 0.0003}, "items": [)" +
      (empty ? "" : items) + "]}";
  FileT file;
  file.name = "job.json", file.media_type = "application/json", file.content.assign(text.begin(), text.end());
  return file;
}

PointsT make_truth() {
  PointsT truth;
  for (const auto& [id, x] : {std::pair{"b0", 100.0}, {"b1", 102.0}, {"b2", 104.0}}) {
    auto point = std::make_unique<PointT>();
    point->id = id, point->position = {x, 200, 30}, point->sigma.setZero();
    truth.points.push_back(std::move(point));
  }
  return truth;
}

class Robot : public testing::TestWithParam<std::string> {
 protected:
  static NodeHarness prepared(const FileT& job, uint64_t seed = 1) {
    NodeHarness node(GetParam());
    node.input<File>("job", job);
    node.input<Points>("truth", make_truth());
    node.seed(seed);
    return node;
  }
  static NodeHarness done(const FileT& job, uint64_t seed = 1) {
    NodeHarness node = prepared(job, seed);
    node.run();
    return node;
  }
};

TEST_P(Robot, MovesWhatTheJobNamesAboutAsFarAsItAsks) {
  const PointsT before = make_truth();
  const Vector3d asked[] = {{0, -0.006, 0.004}, {-0.003, 0, 0}, {0, 0, 0}};
  Vector3d mean[3] = {Vector3d::Zero(), Vector3d::Zero(), Vector3d::Zero()};
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    const PointsT after = done(make_job(), seed).output<Points>("truth");
    ASSERT_EQ(after.points.size(), 3u);
    for (size_t i = 0; i < 3; ++i) {
      ASSERT_EQ(after.points[i]->id, before.points[i]->id);
      mean[i] += (after.points[i]->position - before.points[i]->position) / 20;
    }
    EXPECT_EQ(after.points[2]->position, before.points[2]->position) << "b2 is not in the job";
  }
  for (size_t i = 0; i < 3; ++i)
    EXPECT_LT((mean[i] - asked[i]).cwiseAbs().maxCoeff(), 0.002) << before.points[i]->id << ": " << mean[i].transpose();
}

TEST_P(Robot, ReportsOnEachItemOnceWithItsJobAndRevision) {
  const ActualsT reports = done(make_job()).output<Actuals>("actuals");
  ASSERT_EQ(reports.items.size(), 3u);
  std::set<std::string> ids;
  for (const auto& report : reports.items) {
    ids.insert(report->item);
    EXPECT_EQ(report->job, "job-1");
    EXPECT_EQ(report->revision, 2);
    EXPECT_TRUE(report->outcome == "done" || report->outcome == "failed" || report->outcome == "skipped");
    EXPECT_FALSE(report->by.empty());
    if (report->item == "p0" && report->outcome == "done") {
      const Vector3d target(101, 200, 29);
      EXPECT_LT((report->measured - target).norm(), 0.03) << "where it hangs, in the root frame";
      EXPECT_GT((report->measured - target).norm(), 1e-6) << "measured, not the target's own number";
    }
  }
  EXPECT_EQ(ids, (std::set<std::string>{"b0", "b1", "p0"}));
}

TEST_P(Robot, DoesNothingByAnEmptyJobAndRefusesNone) {
  const NodeHarness node = done(make_job(true));
  EXPECT_TRUE(node.output<Actuals>("actuals").items.empty());
  const PointsT after = node.output<Points>("truth"), before = make_truth();
  for (size_t i = 0; i < 3; ++i) EXPECT_EQ(after.points.at(i)->position, before.points[i]->position);
  FileT none = make_job();
  none.content = {'{', '}'};
  EXPECT_THROW(done(none), NodeFailed);
}

TEST_P(Robot, DrawsItsErrorsFromTheSeed) {
  const NodeHarness a = done(make_job(), 3), b = done(make_job(), 3), other = done(make_job(), 4);
  EXPECT_EQ(a.output_bytes("truth"), b.output_bytes("truth"));
  EXPECT_EQ(a.output_bytes("actuals"), b.output_bytes("actuals"));
  EXPECT_NE(a.output_bytes("truth"), other.output_bytes("truth"));
}

/// What a plan takes of whoever works by it is in the job.
TEST_P(Robot, TellsWhereThePlanTookLessThanItErrs) {
  const auto is_told = [](const std::string& sigma) {
    FileT job = make_job();
    std::string text(job.content.begin(), job.content.end());
    for (const std::string key : {"settingSigma\": 0.0005", "stationSigma\": 0.0003"})
      text.replace(text.find(key), key.size(), key.substr(0, key.find(' ') + 1) + sigma);
    job.content.assign(text.begin(), text.end());
    const NodeHarness node = done(job);
    return std::any_of(node.warnings().begin(), node.warnings().end(), [](const std::string& warning) {
      return warning.find("give the planner setting_sigma=") != std::string::npos;
    });
  };
  EXPECT_TRUE(is_told("1e-9"));
  EXPECT_FALSE(is_told("0.05"));
}

TEST_P(Robot, EveryParameterHasItsEffect) {
  const auto situation = [](const std::string& name, const std::string& value) -> Situation {
    return [=] {
      NodeHarness node = prepared(make_job());
      if (!name.empty() && node.has_parameter(name, value)) node.set(name, value);
      return node;
    };
  };
  EXPECT_EQ(parameters_at_fault({situation("", ""), situation("slip_share", "1")}), "");
}

// ---------------------------------------------------------------------------------- the models of robots that come
// along

/// Where b0, b1 and b2 go by one kind of robot without errors of its own but for those that are set, in one job.
struct Done {
  std::vector<Vector3d> moved;
  ActualsT reports;
  double faults = 0;
  Done(const char* kind, const std::map<std::string, std::string>& settings, uint64_t seed = 1) {
    NodeHarness node(kind);
    node.input<File>("job", make_job()), node.input<Points>("truth", make_truth());
    for (const char* none : {"repeatability", "station_sigma", "slip_share", "calibration", "hand_sigma", "division"})
      if (node.has_parameter(none, "0")) node.set(none, "0");
    for (const auto& [name, value] : settings) node.set(name, value);
    node.seed(seed), node.run();
    const PointsT after = node.output<Points>("truth"), before = make_truth();
    for (size_t i = 0; i < 3; ++i) moved.push_back(after.points[i]->position - before.points[i]->position);
    reports = node.output<Actuals>("actuals"), faults = node.metric("faults");
  }
};

/// Elsewhere this file is the kit of another robot.
bool are_built_here() {
  const auto kinds = kinds_of_role("robot");
  return std::find(kinds.begin(), kinds.end(), "simulate.robots") != kinds.end();
}

void expect_moved(const Done& done, const Vector3d& b0, const Vector3d& b1, const std::string& how) {
  EXPECT_LT((done.moved[0] - b0).norm(), 1e-12) << how << ": " << done.moved[0].transpose();
  EXPECT_LT((done.moved[1] - b1).norm(), 1e-12) << how << ": " << done.moved[1].transpose();
  EXPECT_EQ(done.moved[2], Vector3d(0, 0, 0)) << how;
}

/// In the frame of the site: asked are 4 mm up and 6 mm out of a facade that faces -y, and 3 mm to the left.
TEST(SimulatedRobots, EachFaultIsThatOfItsName) {
  if (!are_built_here()) GTEST_SKIP() << "simulate.robots is not built here";
  const Vector3d b0(0, -0.006, 0.004), b1(-0.003, 0, 0), none(0, 0, 0), aside(0.008, 0, 0);
  const auto with = [](const std::string& fault) { return Done("simulate.robots", {{fault, "1"}}); };
  expect_moved(Done("simulate.robots", {}), b0, b1, "no fault");
  EXPECT_EQ(Done("simulate.robots", {}).faults, 0);
  expect_moved(with("did_nothing"), none, none, "did_nothing");
  const Vector3d off = with("off_8mm").moved[0] - b0, off_too = with("off_8mm").moved[1] - b1;
  EXPECT_LT(std::min((off - aside).norm(), (off + aside).norm()), 1e-12) << off.transpose();
  EXPECT_LT(std::min((off_too - aside).norm(), (off_too + aside).norm()), 1e-12) << off_too.transpose();
  expect_moved(with("twice"), 2 * b0, 2 * b1, "twice");
  const Done other = with("other_job");
  EXPECT_GT((other.moved[0] - b0).norm(), 0.001) << "as another job asks";
  EXPECT_EQ(other.reports.items[0]->job, "job-of-another-tower");
  expect_moved(with("wrong_side"), -b0, -b1, "wrong_side");
  expect_moved(with("wrong_item"), none, b0, "wrong_item: b1 is set as b0 was to be, and nobody hangs on p0");
  expect_moved(with("skipped"), none, none, "skipped");
  expect_moved(with("old_revision"), b0, b1, "old_revision");
  for (const char* fault : {"did_nothing", "skipped", "old_revision", "off_8mm"})
    EXPECT_EQ(with(fault).faults, 3) << fault;
  for (const char* fault : {"wrong_side", "wrong_item", "twice", "other_job"})
    EXPECT_EQ(with(fault).faults, 2) << fault;
  for (const auto& report : with("skipped").reports.items) EXPECT_EQ(report->outcome, "skipped");
  for (const auto& report : with("did_nothing").reports.items) EXPECT_EQ(report->outcome, "done") << "and says it was";
  for (const auto& report : with("old_revision").reports.items) EXPECT_EQ(report->revision, 1);
}

/// Root mean square of what is off, each direction; a station's is common to all brackets of a floor.
TEST(SimulatedRobots, ErrorsAreOfTheirSizeAndTheirKind) {
  if (!are_built_here()) GTEST_SKIP() << "simulate.robots is not built here";
  const Vector3d asked[] = {{0, -0.006, 0.004}, {-0.003, 0, 0}};
  const auto rms = [&](const char* kind, const std::map<std::string, std::string>& settings) {
    double own = 0, apart = 0;
    for (uint64_t seed = 1; seed <= 100; ++seed) {
      const Done done(kind, settings, seed);
      const Vector3d first = done.moved[0] - asked[0], second = done.moved[1] - asked[1];
      own += (first.squaredNorm() + second.squaredNorm()) / 600, apart += (first - second).squaredNorm() / 300;
    }
    return std::pair(std::sqrt(own), std::sqrt(apart));
  };
  const auto repeated = rms("simulate.robots", {{"repeatability", "0.001"}});
  EXPECT_NEAR(repeated.first, 0.001, 0.00015);
  EXPECT_NEAR(repeated.second, 0.001 * std::sqrt(2.0), 0.0002);
  const auto station = rms("simulate.robots", {{"station_sigma", "0.001"}});
  EXPECT_NEAR(station.first, 0.001, 0.0002);
  EXPECT_LT(station.second, 1e-12) << "of one floor";
  const auto arm = rms("simulate.robots", {{"calibration", "0.001"}});
  EXPECT_LT(arm.second, 1e-12) << "of one robot";
  const auto first_round = Done("simulate.robots", {{"calibration", "0.001"}}, 1).moved[0];
  EXPECT_GT((first_round - asked[0]).norm(), 1e-5);
  EXPECT_EQ(first_round, Done("simulate.robots", {{"calibration", "0.001"}}, 2).moved[0]) << "in all rounds";
  const auto tilted = rms("simulate.robots", {{"tilt", "0.001"}});
  EXPECT_NEAR(tilted.first, 0.0024, 0.0008) << "2 m up and 1.5 m before it";
  EXPECT_GT(tilted.second, 1e-4) << "by where it is";
  const auto drifted = rms("simulate.robots", {{"drift", "0.001"}});
  EXPECT_NEAR(drifted.second, 0.001, 0.0002) << "one item on";
  const auto wandered = rms("simulate.robots", {{"bit_wander", "0.001"}});
  EXPECT_NEAR(wandered.first, 0.001 * std::sqrt(2.0 / 3), 0.00015) << "along the facade alone";
  EXPECT_NEAR(rms("simulate.robots", {{"slip_share", "1"}, {"slip_sigma", "0.004"}}).first, 0.004, 0.0006);
  EXPECT_NEAR(rms("simulate.fitters", {{"hand_sigma", "0.002"}}).first, 0.002, 0.0003);
  const Done rounded("simulate.fitters", {{"division", "0.005"}});  // 4 and 6 mm are 5, 3 mm are 5
  expect_moved(rounded, {0, -0.005, 0.005}, {-0.005, 0, 0}, "division");
}

/// What the plan has to take is what all that a floor is worked on with adds up to: of b1, the second one, two drifts,
/// and tilt times the 2.82 m from the base that turn along one axis. It was one drift, and 2.5 m.
TEST(SimulatedRobots, ThePlanIsToldOfAllDriftAndTheWholeArm) {
  if (!are_built_here()) GTEST_SKIP() << "simulate.robots is not built here";
  const auto told = [](const char* name, const char* value) {
    NodeHarness node("simulate.robots");
    node.input<File>("job", make_job()), node.input<Points>("truth", make_truth());
    for (const char* none : {"repeatability", "station_sigma", "slip_share", "calibration"}) node.set(none, "0");
    node.set(name, value), node.run();
    const std::string before = "give the planner station_sigma=";
    for (const std::string& warning : node.warnings())
      if (const auto at = warning.find(before); at != std::string::npos) return warning.substr(at + before.size());
    return std::string("nothing");
  };
  EXPECT_EQ(told("drift", "0.001"), "0.00141");
  EXPECT_EQ(told("tilt", "0.001"), "0.00282");
  EXPECT_EQ(told("drift", "0.0002"), "nothing") << "0.28 mm, and the plan took 0.3";
}

/// A panel is seen where its hooks really put it, with the plan that says which they are, and not at its target.
TEST(SimulatedRobots, APanelHangsWhereItsHooksAre) {
  if (!are_built_here()) GTEST_SKIP() << "simulate.robots is not built here";
  const auto seen = [](const std::map<std::string, std::string>& settings, double off) {
    InstallationPlanT plan;
    auto panel = std::make_unique<PlannedPanelT>();
    panel->id = "p0", panel->centre = {101, 200, 29}, panel->shift.setZero(), panel->rotation.setZero();
    for (const double z : {28.0, 30.0})
      for (const double x : {100.0, 102.0}) panel->corners.emplace_back(x, 200, z);
    for (int k = 0; k < 4; ++k) {
      auto bracket = std::make_unique<BracketSettingT>();
      bracket->id = std::string("c") + std::to_string(k), bracket->design = panel->corners[k];
      bracket->measured = bracket->sigma = bracket->difference_sigma = bracket->asked = Vector3d::Zero();
      bracket->setting = bracket->low = bracket->high = Vector3d::Zero();
      bracket->axes = {Vector3d(1, 0, 0), Vector3d(0, 0, 1), Vector3d(0, -1, 0)};
      panel->brackets.push_back(bracket->id), panel->holds.push_back(k == 2   ? "right+up+out"
                                                                     : k == 3 ? "up+out"
                                                                              : "out");
      plan.brackets.push_back(std::move(bracket));
    }
    PointsT truth = make_truth();
    for (const auto& bracket : plan.brackets) {
      auto point = std::make_unique<PointT>();
      point->id = bracket->id, point->position = bracket->design + Vector3d(off, -off, 0), point->sigma.setZero();
      truth.points.push_back(std::move(point));
    }
    plan.basis = "abc", plan.panels.push_back(std::move(panel));
    NodeHarness node("simulate.robots");
    node.input<File>("job", make_job()), node.input<Points>("truth", truth), node.input<InstallationPlan>("plan", plan);
    node.set("seen_sigma", "1e-5"), node.set("face_sigma", "0");
    for (const auto& [name, value] : settings) node.set(name, value);
    node.run();
    for (const auto& report : node.output<Actuals>("actuals").items)
      if (report->item == "p0") return Vector3d(report->measured - Vector3d(101, 200, 29));
    return Vector3d(Vector3d::Constant(std::nan("")));
  };
  EXPECT_LT((seen({}, 0.006) - Vector3d(0.006, -0.006, 0)).norm(), 1e-4);
  EXPECT_LT((seen({{"off_8mm", "1"}}, 0) - Vector3d(0.008, 0, 0)).norm(), 1e-4);
  EXPECT_GT(std::abs(seen({{"face_sigma", "0.01"}}, 0).y()), 1e-4) << "as it was made";
  EXPECT_TRUE(std::isnan(seen({{"did_nothing", "1"}}, 0).x()));
}

GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(Robot);
INSTANTIATE_TEST_SUITE_P(Role, Robot, testing::ValuesIn(kinds_of_role("robot")), test_name);

}  // namespace robot_tests

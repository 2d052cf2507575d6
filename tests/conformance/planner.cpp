// What every planner must do: plan every panel that was judged, within the ranges of its brackets, and let nothing be
// hung that would not hang right, was not measured or rests on a measurement in doubt.
#include <cmath>
#include <numeric>
#include <tuple>

#include "artifacts/design.hpp"
#include "artifacts/deviation.hpp"
#include "artifacts/file.hpp"
#include "artifacts/installation_plan.hpp"
#include "artifacts/loop_state.hpp"
#include "artifacts/points.hpp"
#include "artifacts/poses.hpp"
#include "geometry/random.hpp"
#include "node_harness.hpp"
#include "parameter_effects.hpp"
#include "stopping.hpp"

namespace planner_tests {

using namespace plumbline;
using namespace plumbline::test;
using Eigen::Vector3d;

constexpr double kWidth = 2, kHeight = 3, kLimit = 0.005;  // [m]
const double kNone = std::nan("");

/// A facade that faces -y: two panels side by side with a joint between them, each on anchors at its four corners,
/// bottom left, bottom right, top left, top right. Right, up and out are x, z and -y.
struct Site {
  DeviationT deviation;
  PointsT model;
  DesignT design;
  PointsT control;

  /// Anchors are off by up to about three `sigma` [m]; known to `u` [m] and to each other by less: they have a control
  /// point in common.
  explicit Site(double sigma, double u = 0.0002, uint64_t seed = 1) {
    Random random(seed);
    for (int j = 0; j < 2; ++j) add_panel("P" + std::to_string(j), {j * (kWidth + 0.02), 0, 0}, random, sigma);
    auto joint = std::make_unique<PanelJointT>();
    joint->panel = joint->name = "P1", joint->side = "right", joint->design = 0.02, joint->change = within(0.004);
    deviation.panels[0]->joints.push_back(std::move(joint));
    for (PointsT* points : {&model, &control}) {
      points->points.push_back(std::make_unique<PointT>());
      PointT& mark = *points->points.back();
      mark.id = "K1", mark.role = "control", mark.position = {-3, -5, 1}, mark.sigma.setConstant(u);
    }
    const size_t n = 3 * model.points.size();
    for (size_t i = 0; i < n; ++i)
      for (size_t k = 0; k <= i; ++k)
        model.covariance.push_back(u * u * ((i == k ? 0.5 : 0) + (i % 3 == k % 3 ? 0.5 : 0)));
    for (size_t i = 0; i < 3; ++i)
      for (size_t k = 0; k <= i; ++k) control.covariance.push_back(i == k ? u * u : 0);
  }

  static std::unique_ptr<FacadeFrameT> frame() {
    auto frame = std::make_unique<FacadeFrameT>();
    frame->right = Vector3d::UnitX(), frame->up = Vector3d::UnitZ(), frame->out = -Vector3d::UnitY();
    frame->confirmed = true, frame->facade = "South";
    return frame;
  }
  static std::unique_ptr<JudgedLengthT> within(double tolerance) {
    auto length = std::make_unique<JudgedLengthT>();
    length->tolerance = tolerance;
    return length;
  }
  void add_panel(const std::string& name, const Vector3d& place, Random& random, double sigma) {
    auto panel = std::make_unique<PanelDeviationT>();
    panel->guid = panel->name = name, panel->floor = 1, panel->facade = frame();
    panel->sideways = within(kLimit), panel->vertical = within(kLimit), panel->out_of_plane = within(kLimit);
    panel->shift.setZero(), panel->rotation.setZero();
    const char* corners[] = {"bottom_left", "bottom_right", "top_left", "top_right"};
    for (int k = 0; k < 4; ++k) {
      auto corner = std::make_unique<PanelCornerT>();
      corner->name = corners[k], corner->movement.setZero();
      corner->design = place + Vector3d(k % 2 * kWidth, 0, k / 2 * kHeight);
      auto anchor = std::make_unique<AnchorDeviationT>();
      anchor->id = name + "-" + std::to_string(k), anchor->class_ = "IfcPlate", anchor->floor = 1;
      anchor->design = corner->design, anchor->deviation = random.normal3(sigma);
      anchor->as_built = anchor->design + anchor->deviation;
      anchor->target_offset.setZero(), anchor->facade = frame();
      auto point = std::make_unique<PointT>();
      point->id = anchor->id, point->position = anchor->as_built, point->sigma.setConstant(0.0002);
      model.points.push_back(std::move(point));
      auto fixing = std::make_unique<PanelFixingT>();
      fixing->anchor = anchor->id;
      panel->fixings.push_back(std::move(fixing));
      panel->corners.push_back(std::move(corner));
      deviation.anchors.push_back(std::move(anchor));
    }
    deviation.panels.push_back(std::move(panel));
  }
};

class Planner : public testing::TestWithParam<std::string> {
 protected:
  static NodeHarness prepared(const Site& site, const std::map<std::string, std::string>& settings = {}) {
    NodeHarness node(GetParam());
    node.input<Deviation>("deviation", site.deviation);
    node.input<Points>("model", site.model);
    node.input<Design>("design", site.design);
    for (const auto& [name, value] : settings)
      if (node.has_parameter(name, value)) node.set(name, value);
    return node;
  }
  static InstallationPlanT planned(const Site& site, const std::map<std::string, std::string>& settings = {}) {
    NodeHarness node = prepared(site, settings);
    node.run();
    return node.output<InstallationPlan>("plan");
  }
  static const BracketSettingT& bracket(const InstallationPlanT& plan, const std::string& id) {
    for (const auto& bracket : plan.brackets)
      if (bracket->id == id) return *bracket;
    throw std::runtime_error("no bracket " + id);
  }
  static const PlannedPanelT& panel(const InstallationPlanT& plan, const std::string& id) {
    for (const auto& panel : plan.panels)
      if (panel->id == id) return *panel;
    throw std::runtime_error("no panel " + id);
  }
};

TEST_P(Planner, PlansEveryPanelAndEveryAnchorOnceAndCountsThem) {
  const InstallationPlanT plan = planned(Site(0.004));
  std::set<std::string> brackets, panels;
  for (const auto& b : plan.brackets) brackets.insert(b->id);
  for (const auto& p : plan.panels) panels.insert(p->id);
  EXPECT_EQ(plan.brackets.size(), 8u);
  EXPECT_EQ(brackets.size(), 8u);
  EXPECT_EQ(panels, (std::set<std::string>{"P0", "P1"}));
  EXPECT_EQ(plan.panels.size(), 2u);
  EXPECT_EQ(plan.go + plan.hold + plan.no_go, 2);
  EXPECT_EQ(plan.basis.size(), 64u) << "jobs and state rest on it: the SHA-256 of what was measured";
}

TEST_P(Planner, MovesNothingWhereAllIsRightAndLetsItBeHung) {
  const InstallationPlanT plan = planned(Site(0));
  for (const auto& b : plan.brackets) EXPECT_LT(b->setting.cwiseAbs().maxCoeff(), 1e-4) << b->id;
  for (const auto& p : plan.panels) EXPECT_EQ(p->gate, GateDecision::go) << p->id << ": " << p->reason;
}

TEST_P(Planner, SetsWithinRangeAndInSteps) {
  const InstallationPlanT plan = planned(Site(0.015), {{"brackets", "*: right=10mm, up=8mm, out=12mm, step_out=1mm"}});
  double largest = 0;
  for (const auto& b : plan.brackets) {
    EXPECT_LE(std::abs(b->setting.x()), 0.010 + 1e-9) << b->id;
    EXPECT_LE(std::abs(b->setting.y()), 0.008 + 1e-9) << b->id;
    EXPECT_LE(std::abs(b->setting.z()), 0.012 + 1e-9) << b->id;
    EXPECT_NEAR(1e3 * b->setting.z(), std::round(1e3 * b->setting.z()), 1e-6)
        << b->id << " is set in whole millimetres";
    largest = std::max(largest, b->setting.cwiseAbs().maxCoeff());
  }
  EXPECT_GT(largest, 0.003);
}

/// By the geometry of the panel alone: it hangs on its upper left hook, slides sideways on the upper right one, and is
/// held out of plane by all four.
TEST_P(Planner, WhatIsGoHangsWithinItsLimitsWhenTheSettingsAreDone) {
  int go = 0;
  for (uint64_t seed = 1; seed <= 12; ++seed) {
    const Site site(0.006, 0.0002, seed);
    const InstallationPlanT plan = planned(site);
    for (size_t j = 0; j < 2; ++j) {
      const std::string name = "P" + std::to_string(j);
      if (panel(plan, name).gate != GateDecision::go) continue;
      ++go;
      std::array<Vector3d, 4> at;  // right, up, out of each anchor when it is set
      for (size_t k = 0; k < 4; ++k) {
        const Vector3d& d = site.deviation.anchors[4 * j + k]->deviation;
        at[k] = Vector3d(d.x(), d.z(), -d.y()) + bracket(plan, name + "-" + std::to_string(k)).setting;
      }
      const double warp = 0.25 * (at[0].z() - at[1].z() - at[2].z() + at[3].z());
      const double turn = (at[3].y() - at[2].y()) / kWidth;
      for (size_t k = 0; k < 4; ++k) {
        const double out = at[k].z() - (k == 0 || k == 3 ? warp : -warp);
        const double up = at[2].y() + turn * kWidth * static_cast<double>(k % 2);
        const double right = at[2].x() + (k < 2 ? turn * kHeight : 0);
        EXPECT_LT(std::max({std::abs(out), std::abs(up), std::abs(right)}), kLimit)
            << "seed " << seed << ", corner " << k << " of " << name << ": " << right << " " << up << " " << out;
      }
    }
  }
  EXPECT_GE(go, 12) << "of 24 panels";
}

TEST_P(Planner, WhatCannotBeReachedIsNotGo) {
  Site site(0);
  site.deviation.anchors[2]->deviation.z() = site.deviation.anchors[3]->deviation.z() = -0.060;  // 15 mm up it has
  for (size_t k : {2u, 3u}) {
    site.deviation.anchors[k]->as_built = site.deviation.anchors[k]->design + site.deviation.anchors[k]->deviation;
    site.model.points[k]->position = site.deviation.anchors[k]->as_built;
  }
  const InstallationPlanT plan = planned(site);
  EXPECT_EQ(panel(plan, "P0").gate, GateDecision::no_go) << panel(plan, "P0").reason;
  EXPECT_FALSE(plan.relaxations.empty()) << "what would have to be drilled again is named";
}

TEST_P(Planner, WhatWasNotMeasuredWaits) {
  Site site(0);
  site.deviation.anchors[1]->deviation.setConstant(kNone), site.deviation.anchors[1]->as_built.setConstant(kNone);
  auto& fixings = site.deviation.panels[0]->fixings;
  fixings.erase(fixings.begin() + 1);
  site.deviation.panels[0]->missing = {"P0-1"};
  const InstallationPlanT plan = planned(site);
  EXPECT_EQ(panel(plan, "P0").gate, GateDecision::hold);
  EXPECT_FALSE(bracket(plan, "P0-1").measured.allFinite());
}

TEST_P(Planner, NothingIsGoByAMeasurementInDoubt) {
  Site site(0);
  auto doubt = std::make_unique<MeasurementDoubtT>();
  doubt->part = MeasurementPart::survey, doubt->grade = DoubtGrade::doubt,
  doubt->reason = "station 3 contradicts itself";
  site.deviation.doubts.push_back(std::move(doubt));
  const InstallationPlanT plan = planned(site);
  EXPECT_EQ(plan.go, 0);
  ASSERT_EQ(plan.doubts.size(), 1u) << "the state verifies nothing by it";
  EXPECT_NE(plan.doubts[0].find("station 3 contradicts itself"), std::string::npos) << plan.doubts[0];
}

TEST_P(Planner, WhatHangsIsNotSetAnyMore) {
  LoopStateT state;
  for (const char* id : {"P0-0", "P0-1", "P0-2", "P0-3", "P0"}) {
    auto item = std::make_unique<LoopItemT>();
    item->id = id, item->kind = item->id == "P0" ? "panel" : "bracket", item->floor = 1;
    item->status = ItemStatus::verified, item->revision = 1, item->hangs = item->seen = item->kind == "panel";
    item->setting.setZero(), item->pending.setZero(), item->expected.setZero();
    state.items.push_back(std::move(item));
  }
  NodeHarness node = prepared(Site(0.003));
  node.input<LoopState>("state", state);
  node.run();
  const InstallationPlanT plan = node.output<InstallationPlan>("plan");
  EXPECT_TRUE(panel(plan, "P0").installed);
  for (int k = 0; k < 4; ++k) {
    const BracketSettingT& b = bracket(plan, "P0-" + std::to_string(k));
    EXPECT_TRUE(b.fixed);
    EXPECT_EQ(b.setting, Vector3d(0, 0, 0)) << b.id;
  }
  EXPECT_FALSE(panel(plan, "P1").installed);
}

/// Poses that take their calibration as exact state too little; those that do not say so may.
TEST_P(Planner, RefusesStationsThatTakeTheirCalibrationAsExactAndTellsOfThoseThatDoNotSay) {
  PosesT stations;
  stations.poses.push_back(std::make_unique<PoseT>());
  stations.poses[0]->path = "robot-1.jpg";
  for (size_t i = 0; i < 6; ++i)
    for (size_t j = 0; j <= i; ++j) stations.poses[0]->covariance.push_back(i == j ? 1e-9 : 0);
  const auto said = [&](CalibrationErrors calibration) -> std::string {
    stations.calibration = calibration;
    NodeHarness node = prepared(Site(0.002));
    node.input<Poses>("stations", stations);
    try {
      node.run();
    } catch (const std::exception& error) {
      return error.what();
    }
    const InstallationPlanT plan = node.output<InstallationPlan>("plan");
    std::string notes;
    for (const std::string& note : plan.notes) notes += note + "\n";
    return notes;
  };
  EXPECT_NE(said(CalibrationErrors::taken_as_exact).find("give the camera its standard deviations"), std::string::npos);
  EXPECT_NE(said(CalibrationErrors::not_said).find("of their calibration is not said"), std::string::npos);
  const std::string carried = said(CalibrationErrors::carried);
  EXPECT_EQ(carried.find("calibration"), std::string::npos) << carried;
  EXPECT_NE(carried.find("robots know their place by what they see"), std::string::npos) << carried;
}

/// What robots know of their own place enters the gate.
TEST_P(Planner, ARobotThatHardlyKnowsWhereItIsLowersWhatIsGo) {
  std::vector<double> p;
  for (const double sigma : {0.0001, 0.003}) {
    PosesT stations;
    auto pose = std::make_unique<PoseT>();
    pose->path = "robot-1.jpg";
    pose->cam_from_world.rotation = Eigen::AngleAxisd(0.5 * std::acos(-1.0), Vector3d::UnitX());
    pose->cam_from_world.translation = pose->cam_from_world.rotation * Vector3d(-2, 4, -1.5);
    for (size_t i = 0; i < 6; ++i)
      for (size_t j = 0; j <= i; ++j) pose->covariance.push_back(i == j ? sigma * sigma / (i < 3 ? 16 : 1) : 0);
    stations.poses.push_back(std::move(pose));
    stations.calibration = CalibrationErrors::carried;
    NodeHarness node = prepared(Site(0.002));
    node.input<Poses>("stations", stations);
    node.run();
    p.push_back(panel(node.output<InstallationPlan>("plan"), "P0").p_in);
  }
  EXPECT_GT(p[0], 0.9);
  EXPECT_LT(p[1], p[0] - 0.1);
}

TEST_P(Planner, GivesTheSameBitsTwice) {
  NodeHarness a = prepared(Site(0.004)), b = prepared(Site(0.004));
  a.run(), b.run();
  for (const char* port : {"plan", "table", "words"}) EXPECT_EQ(a.output_bytes(port), b.output_bytes(port)) << port;
}

/// Which of them a parameter sets is seen by what it changes, and by what it leaves as it is.
TEST_P(Planner, ErrorsThatAPlanTakesAreThoseOfTheirNames) {
  const Site site(0.002, 0.0003, 3);
  const auto uncertainty = [](const InstallationPlanT& plan, const std::string& quantity) {
    double sum = 0;
    for (const auto& length : plan.lengths)
      if (length->quantity == quantity) sum += length->u;
    return sum;
  };
  const InstallationPlanT before = planned(site);
  ASSERT_GT(uncertainty(before, "gap"), 0);
  ASSERT_GT(uncertainty(before, "step"), 0);
  for (const auto& [parameter, of, not_of] :
       {std::tuple("edge_sigma", "gap", "step"), std::tuple("face_sigma", "step", "gap")}) {
    if (!prepared(site).has_parameter(parameter, "0.004")) continue;
    const InstallationPlanT after = planned(site, {{parameter, "0.004"}});
    EXPECT_GT(uncertainty(after, of), 2 * uncertainty(before, of)) << parameter;
    EXPECT_EQ(uncertainty(after, not_of), uncertainty(before, not_of)) << parameter;
  }
  const InstallationPlanT told =
      planned(site, {{"setting_sigma", "0.0007"}, {"station_sigma", "0.0011"}, {"guard_factor", "1.5"}});
  EXPECT_EQ(told.setting_sigma, 0.0007);
  EXPECT_EQ(told.station_sigma, 0.0011);
  EXPECT_EQ(told.guard_factor, 1.5);
  const std::vector<std::pair<std::string, std::string>> accidents = {
      {"slip_share", "slip_sigma"}, {"knock_share", "knock_sigma"}, {"control_share", "control_sigma"}};
  for (const auto& [share, own] : accidents) {
    const auto p = [&, &share = share](const std::string& sigma, const char* size) {
      return panel(planned(site, {{share, "0.1"}, {sigma, size}}), "P0").p_in;
    };
    if (!prepared(site).has_parameter(share, "0.1")) continue;
    EXPECT_LT(p(own, "0.05"), p(own, "0.0001") - 0.03) << own;
    for (const auto& [ignored, other] : accidents) {
      if (other == own) continue;
      EXPECT_EQ(p(other, "0.05"), p(other, "0.0001")) << other << " with " << share;
    }
  }
}

TEST_P(Planner, EveryParameterHasItsEffect) {
  const auto situation = [](double sigma, double u, const std::map<std::string, std::string>& settings) -> Situation {
    return [=] {
      const Site site(sigma, u, 3);
      NodeHarness node = prepared(site, settings);
      node.input<Points>("control", site.control);
      return node;
    };
  };
  // HOLD by the measurement, HOLD by the robot, brackets that slip, what is knocked.
  EXPECT_EQ(parameters_at_fault({situation(0.004, 0.0003, {}), situation(0.012, 0.0018, {}),
                                 situation(0.004, 0.0003, {{"slip_share", "0.1"}, {"knock_share", "0.1"}}),
                                 situation(0.004, 0.0003, {{"control_share", "0.1"}})}),
            "");
}

/// Of two panels a planner may be done before it asks; one that solves for hundreds at once asks.
TEST_P(Planner, StopsWhereverItAsks) {
  const Site site(0.001);
  EXPECT_EQ(stopping_at_fault([&] { return prepared(site); }, MayTakeLong::no), "");
}

GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(Planner);
INSTANTIATE_TEST_SUITE_P(Role, Planner, testing::ValuesIn(kinds_of_role("planner")), test_name);

}  // namespace planner_tests

// States of brackets and panels: nothing wrong becomes VERIFIED.
#include "loop/state/machine.hpp"

#include <gtest/gtest.h>

#include "loop/state/place_doubts.hpp"

namespace plumbline::loop {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// Two panels, one above the other, on two brackets each; all anchors 4 mm low.
InstallationPlanT make_plan(const std::string& basis) {
  InstallationPlanT plan;
  plan.basis = basis;
  for (int i = 0; i < 4; ++i) {
    auto bracket = std::make_unique<BracketSettingT>();
    bracket->id = "b" + std::to_string(i), bracket->floor = 1 + i / 2;
    bracket->design = {2.0 * (i % 2), 0, 4.0 * (i / 2)};
    bracket->measured = bracket->design - Eigen::Vector3d(0, 0, 0.004);
    bracket->axes = {Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitZ(), -Eigen::Vector3d::UnitY()};
    bracket->asked = bracket->setting = {0, 0.004, 0};
    bracket->sigma.setConstant(0.0004), bracket->low.setConstant(-0.02), bracket->high.setConstant(0.02);
    plan.brackets.push_back(std::move(bracket));
  }
  for (int j = 0; j < 2; ++j) {
    auto panel = std::make_unique<PlannedPanelT>();
    panel->id = "p" + std::to_string(j), panel->floor = j + 1;
    panel->brackets = {"b" + std::to_string(2 * j), "b" + std::to_string(2 * j + 1)};
    if (j == 1) panel->depends_on = {"p0"};
    panel->centre.setZero(), panel->shift.setZero(), panel->rotation.setZero();
    panel->gate = GateDecision::go, panel->p_in = 0.99, panel->reason = "p 0.990";
    plan.panels.push_back(std::move(panel));
  }
  return plan;
}

LoopItemT& item(LoopStateT& state, const std::string& id) {
  for (auto& i : state.items)
    if (i->id == id) return *i;
  throw std::runtime_error("no " + id);
}

ActualsT done(const std::vector<std::string>& ids, int revision) {
  ActualsT actuals;
  for (const std::string& id : ids) {
    auto actual = std::make_unique<ActualT>();
    actual->item = id, actual->revision = revision, actual->by = "robot-1", actual->outcome = "done";
    actual->measured.setConstant(nan), actual->sigma.setConstant(nan), actual->setting.setConstant(nan);
    actuals.items.push_back(std::move(actual));
  }
  return actuals;
}

/// The plan after brackets 0 and 1 were set, off by `off` in height.
InstallationPlanT plan_after_setting(double off, const std::string& basis = "second") {
  InstallationPlanT plan = make_plan(basis);
  for (int i = 0; i < 2; ++i) {
    plan.brackets[static_cast<std::size_t>(i)]->measured.z() += 0.004 + off;
    plan.brackets[static_cast<std::size_t>(i)]->setting.setZero();
  }
  return plan;
}

TEST(Machine, BracketsComeBeforeTheirPanelAndFloorsBeforeTheNext) {
  LoopStateT state;
  apply_plan(state, make_plan("first"), {});
  EXPECT_EQ(state.revision, 1);
  EXPECT_EQ(item(state, "b0").status, ItemStatus::released);
  EXPECT_EQ(item(state, "p0").status, ItemStatus::planned);
  EXPECT_EQ(item(state, "b2").status, ItemStatus::planned);  // p0 does not hang yet
  EXPECT_TRUE(apply_actuals(state, done({"b0", "b1"}, 1)).empty());
  apply_plan(state, plan_after_setting(0.0004), {});
  EXPECT_EQ(item(state, "b0").status, ItemStatus::verified);
  EXPECT_EQ(item(state, "p0").status, ItemStatus::released);
  EXPECT_TRUE(apply_actuals(state, done({"p0"}, item(state, "p0").revision)).empty());
  InstallationPlanT third = plan_after_setting(0.0004, "third");
  third.panels[0]->installed = true;
  apply_plan(state, third, {});
  EXPECT_EQ(item(state, "p0").status, ItemStatus::verified);
  EXPECT_EQ(item(state, "b2").status, ItemStatus::released);
  EXPECT_EQ(check_journal(state.journal).words, "");
}

TEST(Machine, WithoutANewMeasurementNothingIsVerified) {
  LoopStateT state;
  apply_plan(state, make_plan("first"), {});
  apply_actuals(state, done({"b0", "b1"}, 1));
  apply_plan(state, plan_after_setting(0, "first"), {});
  EXPECT_EQ(item(state, "b0").status, ItemStatus::executed);
}

TEST(Machine, ARobotThatReportsSuccessAndDidNothingIsFound) {
  LoopStateT state;
  apply_plan(state, make_plan("first"), {});
  apply_actuals(state, done({"b0", "b1"}, 1));
  apply_plan(state, make_plan("second"), {});  // measured where they were before
  EXPECT_NE(item(state, "b0").status, ItemStatus::verified);
  EXPECT_EQ(item(state, "b0").reworks, 1);
  EXPECT_EQ(item(state, "p0").status, ItemStatus::planned);
}

TEST(Machine, AtMostSoManyReworks) {
  LoopStateT state;
  MachineOptions options;
  options.most_reworks = 2;
  for (int round = 0; round < 6; ++round) {
    apply_plan(state, make_plan(std::to_string(round)), options);
    apply_actuals(state, done({"b0", "b1"}, item(state, "b0").revision));
  }
  EXPECT_EQ(item(state, "b0").status, ItemStatus::rejected);
  close_round(state);
  EXPECT_TRUE(state.done);
  EXPECT_EQ(state.given_up, 2);
}

TEST(Machine, AHangingPanelOutsideItsLimitsIsTakenDownWithItsBrackets) {
  LoopStateT state;
  apply_plan(state, make_plan("first"), {});
  apply_actuals(state, done({"b0", "b1"}, 1));
  apply_plan(state, plan_after_setting(0), {});
  apply_actuals(state, done({"p0"}, item(state, "p0").revision));
  InstallationPlanT third = plan_after_setting(0.002, "third");
  third.panels[0]->installed = true, third.panels[0]->p_in = 0.01, third.panels[0]->gate = GateDecision::no_go;
  apply_plan(state, third, {});
  EXPECT_EQ(item(state, "p0").reworks, 1);
  EXPECT_EQ(item(state, "b0").reworks, 1);
  EXPECT_EQ(item(state, "p0").status, ItemStatus::planned);
}

TEST(Machine, ABracketThatMovedWithoutAReportIsFound) {
  LoopStateT state;
  apply_plan(state, make_plan("first"), {});
  apply_actuals(state, done({"b0", "b1"}, 1));
  InstallationPlanT second = plan_after_setting(0);
  second.panels[0]->gate = GateDecision::go;
  apply_plan(state, second, {});
  InstallationPlanT third = plan_after_setting(0, "third");
  third.brackets[0]->measured.x() += 0.005;
  apply_plan(state, third, {});
  EXPECT_EQ(item(state, "b0").status, ItemStatus::rejected);
  EXPECT_NE(item(state, "b0").why.find("moved by 5.0 mm without a report that was taken"), std::string::npos);
  EXPECT_EQ(item(state, "b1").status, ItemStatus::verified);
}

TEST(Machine, ReportsThatAreWrongAreNamedAndChangeNothing) {
  LoopStateT state;
  apply_plan(state, make_plan("first"), {});
  item(state, "b1").at = "2026-05-02T08:00:00Z";
  ActualsT actuals = done({"x9", "b0", "b0", "b1", "b2", "b0"}, 1);
  actuals.items[1]->revision = 7;
  actuals.items[2]->outcome = "perhaps";
  actuals.items[3]->at = "2026-05-01T08:00:00Z";
  actuals.items[5]->measured = item(state, "b0").expected / 0.3048 + Eigen::Vector3d(50, 0, 0);
  const auto refused = apply_actuals(state, actuals);
  ASSERT_EQ(refused.size(), 6u);
  EXPECT_NE(refused[0].find("report on x9 by robot-1: no bracket or panel of this name"), std::string::npos);
  EXPECT_NE(refused[1].find("is of revision 7, the item was released with 1"), std::string::npos);
  EXPECT_NE(refused[2].find("outcome 'perhaps', expected done, failed or skipped"), std::string::npos);
  EXPECT_NE(refused[3].find("before the item was released at 2026-05-02"), std::string::npos);
  EXPECT_NE(refused[4].find("the item is PLANNED, not RELEASED: nobody asked for it"), std::string::npos);
  EXPECT_NE(refused[5].find("m from where it should be"), std::string::npos);
  EXPECT_EQ(item(state, "b0").status, ItemStatus::released);
  EXPECT_EQ(item(state, "b1").status, ItemStatus::released);
}

TEST(Machine, TheSameReportTwiceChangesNothingMore) {
  LoopStateT state;
  apply_plan(state, make_plan("first"), {});
  apply_actuals(state, done({"b0"}, 1));
  const auto journal = state.journal;
  EXPECT_EQ(apply_actuals(state, done({"b0"}, 1)),
            std::vector<std::string>{"report on b0 by robot-1: was reported before; nothing changes"});
  EXPECT_EQ(state.journal, journal);
}

TEST(Machine, ControlThatMovedMakesReleasedWorkStale) {
  LoopStateT state;
  apply_plan(state, make_plan("first"), {});
  recall(state, {"CP3"}, "control point CP3 moved by 6.0 mm");
  EXPECT_EQ(item(state, "b0").status, ItemStatus::planned);
  EXPECT_EQ(state.moved_control, std::vector<std::string>{"CP3"});
  const auto refused = apply_actuals(state, done({"b0"}, 1));
  ASSERT_EQ(refused.size(), 1u);
  EXPECT_NE(refused[0].find("not RELEASED"), std::string::npos);
}

TEST(Machine, WhatAMeasurementCannotTellIsNoMove) {
  LoopStateT state;
  apply_plan(state, make_plan("first"), {});
  InstallationPlanT second = make_plan("second");
  second.brackets[2]->measured.x() += 0.005;
  second.brackets[2]->sigma.setConstant(0.001);  // 5.7 mm are four standard deviations of a difference
  apply_plan(state, second, {});
  EXPECT_EQ(item(state, "b2").status, ItemStatus::planned);
}

TEST(Machine, AFloorThatMovedAsAWholeIsNotJudged) {
  InstallationPlanT first = make_plan("first"), second = make_plan("second");
  for (InstallationPlanT* plan : {&first, &second})
    for (auto& bracket : plan->brackets) bracket->floor = 1;
  LoopStateT state;
  apply_plan(state, first, {});
  for (auto& bracket : second.brackets) bracket->measured.z() += 0.006;
  apply_plan(state, second, {});
  EXPECT_EQ(state.moved_control, std::vector<std::string>{"control of floor 1"});
  EXPECT_EQ(item(state, "b0").status, ItemStatus::planned);
  EXPECT_NE(item(state, "b0").why.find("moved together since they were measured last: check their control"),
            std::string::npos);
}

TEST(Machine, ANewAdjustmentWithAnotherResultMakesReleasedSettingsStale) {
  LoopStateT state;
  apply_plan(state, make_plan("first"), {});
  InstallationPlanT second = make_plan("second");
  second.brackets[0]->setting.y() = 0.006;
  apply_plan(state, second, {});
  EXPECT_EQ(item(state, "b0").revision, 2);
  EXPECT_EQ(item(state, "b1").revision, 1);
  EXPECT_NEAR(item(state, "b0").pending.y(), 0.006, 1e-12);
}

TEST(PlaceDoubts, SaysWhatWouldExplainAPlace) {
  const Eigen::Vector3d place(12.5, -0.2, 31.0);
  EXPECT_EQ(place_doubt(place + Eigen::Vector3d(0.05, 0, 0), place, 0.25), "");
  EXPECT_NE(place_doubt(place / 0.3048, place, 0.25).find("if it is in feet"), std::string::npos);
  EXPECT_NE(place_doubt(1e3 * place, place, 0.25).find("if it is in millimetres"), std::string::npos);
  EXPECT_NE(place_doubt({place.y(), place.x(), place.z()}, place, 0.25).find("first two axes are exchanged"),
            std::string::npos);
  EXPECT_NE(place_doubt(place + Eigen::Vector3d(100, 7, 3), place, 0.25).find("in another frame"), std::string::npos);
}

}  // namespace
}  // namespace plumbline::loop

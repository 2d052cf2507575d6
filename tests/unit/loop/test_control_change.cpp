// Control that has other coordinates than before: what is recalled, and what steps add up to.
#include <gtest/gtest.h>

#include "hung_panel.hpp"
#include "loop/state/control_change.hpp"
#include "loop/state/gone_items.hpp"
#include "loop/state/next_words.hpp"
#include "loop/state/plan_artifact.hpp"
#include "random_facade.hpp"
#include "two_floors.hpp"

namespace plumbline::loop {
namespace test_control_change {

using namespace test;

std::unique_ptr<ControlMarkT> mark(const std::string& id, double height) {
  auto out = std::make_unique<ControlMarkT>();
  out->id = id, out->place = {1, 2, height};
  return out;
}

/// What was released is for places on the control as it was; what was verified is measured again on the new one.
TEST(Rounds, ControlWithOtherCoordinatesRecallsWhatIsReleased) {
  for (const double by : {0.0, 0.0001, 0.004}) {
    LoopStateT state;
    InstallationPlanT first = make_plan("first"), second = plan_after_setting(0),
                      third = plan_after_setting(0, "third");
    for (InstallationPlanT* plan : {&first, &second}) plan->control.push_back(mark("CP3", 3));
    third.control.push_back(mark("CP3", 3 + by));
    for (auto& bracket : third.brackets) bracket->measured.z() += by;
    next_plan(state, first);
    apply_actuals(state, done({"b0", "b1"}, 1));
    next_plan(state, second);
    ASSERT_EQ(item(state, "p0").status, ItemStatus::released);
    const int revision = item(state, "p0").revision;
    next_plan(state, third);
    EXPECT_EQ(state.control[0]->place.z(), 3 + by);
    if (by < 0.001) {
      EXPECT_EQ(item(state, "p0").revision, revision);
      continue;
    }
    EXPECT_NE(item(state, "p0").status, ItemStatus::verified);
    EXPECT_TRUE(item(state, "p0").status == ItemStatus::planned || item(state, "p0").revision > revision);
    EXPECT_EQ(apply_actuals(state, done({"p0"}, revision)).size(), 1u);
    std::string journal;
    for (const std::string& line : state.journal) journal += line + "\n";
    EXPECT_NE(journal.find("stale: the control is not that of the campaigns before: it has other coordinates: CP3 by "
                           "4.0 mm"),
              std::string::npos)
        << journal;
    EXPECT_EQ(item(state, "b0").expected.allFinite(), true);
  }
}

/// Steps that are each below a tenth of the tolerance add up: what is out is held against the control it was released
/// on, what was released later against the later one.
TEST(Rounds, SmallStepsOfControlAddUpSinceTheRelease) {
  LoopStateT state;
  InstallationPlanT first = make_plan("first"), second = plan_after_setting(0);
  for (InstallationPlanT* plan : {&first, &second}) plan->control.push_back(mark("CP3", 3));
  next_plan(state, first);
  apply_actuals(state, done({"b0", "b1"}, 1));
  next_plan(state, second);
  ASSERT_EQ(item(state, "p0").status, ItemStatus::released);
  std::vector<bool> out;
  for (int step = 1; step <= 6; ++step) {
    InstallationPlanT plan = plan_after_setting(0, "step " + std::to_string(step));
    plan.control.push_back(mark("CP3", 3 + 0.0002 * step));
    next_plan(state, std::move(plan));
    out.push_back(item(state, "p0").status == ItemStatus::released);
  }
  EXPECT_EQ(out, (std::vector<bool>{true, false, true, true, false, true})) << "recalled each time 0.4 mm are reached";
  std::string journal;
  for (const std::string& line : state.journal) journal += line + "\n";
  EXPECT_NE(journal.find("stale: the control moved in steps since this was released or verified: CP3 by 0.4 mm"),
            std::string::npos)
      << journal;
  EXPECT_EQ(state.controls.size(), 1u) << "nothing rests on the earlier ones any more";
}

TEST(ControlChange, StepsBelowAMicrometreAddUp) {
  ControlMarks kept;
  std::vector<bool> told;
  for (int step = 0; step < 4; ++step) {
    ControlMarks now;
    now.push_back(mark("CP1", 3 + 0.7e-6 * step));
    told.push_back(!control_change(kept, now).none());
    kept = kept_control(kept, now);
  }
  EXPECT_EQ(told, (std::vector<bool>{false, false, true, false}));
}

TEST(ControlChange, NamesWhatMovedWhatIsNewAndWhatIsMissing) {
  ControlMarks before, now;
  for (const char* id : {"CP1", "CP2", "CP3"}) before.push_back(mark(id, 3));
  EXPECT_TRUE(control_change(before, {}).none());
  EXPECT_TRUE(control_change({}, before).none());
  EXPECT_TRUE(control_change(before, before).none());
  now.push_back(mark("CP1", 3)), now.push_back(mark("CP2", 3.0021)), now.push_back(mark("CP7", 3));
  const ControlChange change = control_change(before, now);
  EXPECT_NEAR(change.largest, 0.0021, 1e-12);
  EXPECT_EQ(
      words_of(change),
      "the control is not that of the campaigns before: it has other coordinates: CP2 by 2.1 mm; they did not have "
      "CP7; this campaign does not have CP3");
}

/// A mark that a campaign did not have and the next one has 20 mm off has moved.
TEST(ControlChange, WhatWasMissingOnceIsHeldAgainstWhereItWas) {
  ControlMarks first, second, third;
  for (const char* id : {"CP1", "CP2", "CP3"}) first.push_back(mark(id, 3));
  for (const char* id : {"CP1", "CP2"}) second.push_back(mark(id, 3)), third.push_back(mark(id, 3));
  third.push_back(mark("CP3", 3.02));
  const ControlMarks kept = kept_control(kept_control({}, first), second);
  EXPECT_TRUE(control_change(kept, second).none()) << "missing still: no other control than the last campaign's";
  const ControlChange change = control_change(kept, third);
  EXPECT_NEAR(change.largest, 0.02, 1e-12);
  EXPECT_EQ(change.added, std::vector<std::string>{"CP3"});
  EXPECT_EQ(change.moved.size(), 1u);
  EXPECT_TRUE(control_change(kept_control(kept, third), third).none());
}

TEST(Rounds, ControlWithoutAFloorBlocksEverythingUntilItIsAccepted) {
  LoopStateT state;
  next_plan(state, make_plan("first"));
  apply_actuals(state, done({"b0", "b1"}, 1));
  recall(state, {"CP3"}, "control point CP3 moved by 6.0 mm");
  next_plan(state, plan_after_setting(0));
  EXPECT_EQ(item(state, "b0").status, ItemStatus::executed);
  EXPECT_NE(item(state, "b0").why.find("CP3 moved"), std::string::npos);
  close_round(state);
  EXPECT_TRUE(state.done);  // somebody has to look
  EXPECT_TRUE(accept_item(state, "CP3"));
  next_plan(state, plan_after_setting(0, "third"));
  EXPECT_EQ(item(state, "b0").status, ItemStatus::verified);
}

}  // namespace test_control_change
}  // namespace plumbline::loop

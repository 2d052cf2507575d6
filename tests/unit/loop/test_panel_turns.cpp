// Which panel hangs next: who waits for the one below, beside or above, and who is recalled with it.
#include <gtest/gtest.h>

#include "hung_panel.hpp"
#include "loop/state/control_change.hpp"
#include "loop/state/gone_items.hpp"
#include "loop/state/next_words.hpp"
#include "loop/state/plan_artifact.hpp"
#include "random_facade.hpp"
#include "two_floors.hpp"

namespace plumbline::loop {
namespace test_panel_turns {

using namespace test;

/// Hung now, a panel fixes the bracket that it shares with one whose place is not decided yet.
TEST(Rounds, APanelWaitsForTheOneBesideItThatIsMeasuredOnceMore) {
  LoopStateT state;
  InstallationPlanT first = make_plan("first"), second = plan_after_setting(0), third = plan_after_setting(0, "third");
  for (InstallationPlanT* plan : {&first, &second, &third})
    for (auto& panel : plan->panels) {
      panel->depends_on.clear(), panel->brackets = {"b0", "b1"};
      if (panel->id == "p1") panel->brackets = {"b1", "b0"};
    }
  second.panels[1]->gate = GateDecision::hold, second.panels[1]->p_in = 0.8, second.panels[1]->p_in_repeated = 0.99;
  next_plan(state, first);
  apply_actuals(state, done({"b0", "b1"}, 1));
  next_plan(state, second);
  EXPECT_EQ(item(state, "p0").status, ItemStatus::planned);
  EXPECT_EQ(item(state, "p0").why, "waits for p1, which shares a bracket with it and waits for another campaign");
  next_plan(state, third);
  EXPECT_EQ(item(state, "p0").status, ItemStatus::released);
  EXPECT_EQ(item(state, "p1").status, ItemStatus::released);
}

/// What is interlocked from below cannot be hung first, whoever is to look at the one below.
TEST(Rounds, APanelWaitsUntilTheOneBelowHangsAndSaysForWhich) {
  LoopStateT state = with_hung_panel();
  next_plan(state, plan_after_setting(0, "third"));
  ASSERT_EQ(item(state, "p0").status, ItemStatus::verified) << item(state, "p0").why;
  EXPECT_EQ(item(state, "b2").status, ItemStatus::released);
  LoopStateT open = with_released_panel();
  EXPECT_EQ(item(open, "p1").status, ItemStatus::planned);
  EXPECT_EQ(item(open, "p1").why, "waits for p0, which is to hang before it");
  EXPECT_EQ(item(open, "b2").status, ItemStatus::planned);
  // For a person, and it does not hang: neither does the one above.
  LoopItemT& below = item(open, "p0");
  below.status = ItemStatus::rejected, below.hangs = false;
  next_plan(open, plan_after_setting(0, "third"));
  EXPECT_EQ(item(open, "p1").status, ItemStatus::planned);
  EXPECT_EQ(item(open, "p1").why, "waits for p0, which is to hang before it and is for a person");
  EXPECT_EQ(item(open, "b2").status, ItemStatus::planned);
  close_round(open);
  EXPECT_TRUE(open.done);
  EXPECT_NE(open.next.find("somebody looks at what is named below"), std::string::npos) << open.next;
}

/// It was released while the one below hung.
TEST(Rounds, AReleasedPanelIsRecalledWhereTheOneBelowIsTakenDown) {
  LoopStateT state = with_hung_panel();
  next_plan(state, plan_after_setting(0, "third"));
  LoopItemT& above = item(state, "p1");
  above.status = ItemStatus::released, above.revision = state.revision, above.expected.setZero();
  item(state, "b2").status = item(state, "b3").status = ItemStatus::verified;
  InstallationPlanT fourth = plan_after_setting(0, "fourth");
  fourth.panels[0]->gate = GateDecision::no_go, fourth.panels[0]->p_in = 0.01, fourth.panels[0]->reason = "p 0.010";
  next_plan(state, std::move(fourth));
  EXPECT_EQ(item(state, "p0").status, ItemStatus::rework) << item(state, "p0").why;
  EXPECT_EQ(item(state, "p1").status, ItemStatus::planned);
  EXPECT_EQ(item(state, "p1").why, "waits for p0, which is to hang before it and is to be taken down");
  bool told = false;
  for (const std::string& line : state.journal)
    told = told || line.find("stale: p0, which is to hang before it, is to be taken down") != std::string::npos;
  EXPECT_TRUE(told);
}

TEST(Rounds, AReleasedPanelIsRecalledWhereTheOneBelowMayNotHang) {
  LoopStateT state = with_hung_panel();
  next_plan(state, plan_after_setting(0, "third"));
  LoopItemT& above = item(state, "p1");
  above.status = ItemStatus::released, above.revision = state.revision, above.expected.setZero();
  item(state, "b2").status = item(state, "b3").status = ItemStatus::verified;
  ActualsT failed = done({"p0"}, item(state, "p0").revision);
  failed.items[0]->outcome = "failed";
  EXPECT_TRUE(apply_actuals(state, failed).empty());
  next_plan(state, plan_after_setting(0, "fourth"));
  EXPECT_EQ(item(state, "p1").status, ItemStatus::planned);
  EXPECT_EQ(item(state, "p1").why, "waits for p0, which is to hang before it and is for a person");
}

/// The plan alone counts it GO, because it would hang right.
TEST(Rounds, APlanSaysWhatWaitsForAPanelThatMayNotBeHung) {
  InstallationPlanT plan = make_plan("first");
  EXPECT_EQ(installation_words(plan).find("In their turn"), std::string::npos);
  auto third = std::make_unique<PlannedPanelT>(*plan.panels[1]);
  third->id = "p2", third->depends_on = {"p1"};
  plan.panels.push_back(std::move(third));
  plan.panels[0]->gate = GateDecision::no_go;
  const std::string words = installation_words(plan);
  for (const char* id : {"p1", "p2"})
    EXPECT_NE(
        words.find(std::string("\n  ") + id + ": GO, and waits for p0, which is to hang before it and is NO_GO\n"),
        std::string::npos)
        << words;
  plan.panels[0]->installed = true;
  EXPECT_EQ(installation_words(plan).find("In their turn"), std::string::npos) << "it hangs";
}

TEST(Rounds, APanelAfterOneThatNobodyKnowsWaits) {
  LoopStateT state;
  InstallationPlanT plan = make_plan("first");
  plan.panels[0]->depends_on = {"p9"};
  next_plan(state, std::move(plan));
  EXPECT_EQ(item(state, "b0").status, ItemStatus::planned);
  EXPECT_EQ(item(state, "p0").why, "waits for p9, which is to hang before it and is not planned");
}

/// A job does not hang a panel on a bracket that the same plan sets again.
TEST(Rounds, APanelIsRecalledWhereItsBracketIsSetAgainForTheOneBesideIt) {
  LoopStateT state;
  const auto beside = [](InstallationPlanT plan) {
    plan.panels[1]->depends_on.clear(), plan.panels[1]->brackets = {"b1", "b2"}, plan.panels[1]->floor = 1;
    return plan;
  };
  next_plan(state, beside(make_plan("first")));
  apply_actuals(state, done({"b0", "b1"}, 1));
  InstallationPlanT second = beside(plan_after_setting(0)), third = beside(plan_after_setting(0, "third"));
  second.panels[1]->gate = GateDecision::hold, second.panels[1]->obstacle = PanelObstacle::not_measured;
  next_plan(state, second);
  ASSERT_EQ(item(state, "p0").status, ItemStatus::released);
  third.panels[1]->gate = GateDecision::no_go, third.panels[1]->p_in = 0.01, third.panels[1]->reason = "p 0.010";
  next_plan(state, third);
  ASSERT_EQ(item(state, "b1").status, ItemStatus::planned);
  EXPECT_EQ(item(state, "p0").status, ItemStatus::planned) << item(state, "p0").why;
}

/// It is taken down, and its bracket may be set elsewhere: nothing is hung on that meanwhile.
TEST(Rounds, APanelWaitsForTheOneBesideItThatIsTakenDown) {
  LoopStateT state = with_hung_panel();
  InstallationPlanT third = plan_after_setting(0, "third");
  third.panels[1]->depends_on.clear(), third.panels[1]->brackets = {"b1", "b2"}, third.panels[1]->floor = 1;
  third.panels[0]->gate = GateDecision::no_go, third.panels[0]->p_in = 0.01;
  next_plan(state, third);
  ASSERT_EQ(item(state, "p0").status, ItemStatus::rework);
  EXPECT_EQ(item(state, "p1").why, "waits for p0, which shares a bracket with it and is to be taken down");
  EXPECT_EQ(item(state, "b2").status, ItemStatus::planned);
}

}  // namespace test_panel_turns
}  // namespace plumbline::loop

// Places of a sill that move after they were measured: what they hold waits by name until somebody has looked.
#include <gtest/gtest.h>

#include "loop/state/next_words.hpp"
#include "loop/state/plan_artifact.hpp"
#include "two_floors.hpp"

namespace plumbline::loop {
namespace test_sills {

using namespace test;

/// Two places of a sill, s0 and s1, under the lower panel; s0 is `off` further out than before.
InstallationPlanT on_sill(InstallationPlanT plan, double off = 0) {
  for (const char* id : {"s0", "s1"}) {
    auto sill = std::make_unique<BracketSettingT>(*plan.brackets[0]);
    sill->id = id, sill->use = BracketUse::sill, sill->setting.setZero();
    sill->measured = sill->design = {id[1] == '0' ? 0.5 : 1.5, 0, -0.5};
    plan.brackets.push_back(std::move(sill));
  }
  plan.brackets[4]->measured.y() -= off;
  plan.panels[0]->sills = {"s0", "s1"};
  return plan;
}

ActualsT knocked(const std::string& id) {
  ActualsT reports = done({id}, 0);
  reports.items[0]->outcome = "failed", reports.items[0]->note = "plate knocked", reports.items[0]->by = "Anna";
  return reports;
}

LoopStateT with_first_panel(ItemStatus status) {
  LoopStateT state;
  next_plan(state, on_sill(make_plan("first")));
  apply_actuals(state, done({"b0", "b1"}, 1));
  if (status == ItemStatus::planned) return state;
  next_plan(state, on_sill(plan_after_setting(0)));
  if (status != ItemStatus::released) apply_actuals(state, done({"p0"}, item(state, "p0").revision));
  if (status == ItemStatus::verified) next_plan(state, on_sill(plan_after_setting(0, "third")));
  return state;
}

TEST(Sills, WhatStandsOnAPlaceThatMovedIsForAPersonByName) {
  for (const ItemStatus status :
       {ItemStatus::planned, ItemStatus::released, ItemStatus::executed, ItemStatus::verified}) {
    LoopStateT state = with_first_panel(status);
    ASSERT_EQ(item(state, "p0").status, status) << item(state, "p0").why;
    next_plan(state, on_sill(plan_after_setting(0, "later"), 0.008));
    EXPECT_EQ(item(state, "s0").status, ItemStatus::rejected);
    EXPECT_EQ(item(state, "s1").status, ItemStatus::planned);
    const LoopItemT& panel = item(state, "p0");
    EXPECT_EQ(panel.status, status == ItemStatus::planned ? ItemStatus::planned : ItemStatus::rejected);
    EXPECT_NE(panel.why.find("s0"), std::string::npos) << panel.why;
    EXPECT_EQ(item(state, "p1").status, ItemStatus::planned);
    close_round(state);
    EXPECT_NE(next_words(state).find("look at s0: moved by 8.0 mm"), std::string::npos) << next_words(state);
  }
}

/// The plan that says "GO" with the place as it is measured now does not release it.
TEST(Sills, APlannedPanelWaitsUntilSomebodyHasLookedAtItsSill) {
  LoopStateT state = with_first_panel(ItemStatus::planned);
  next_plan(state, on_sill(plan_after_setting(0, "later"), 0.008));
  EXPECT_EQ(item(state, "p0").why, "waits for its sill: s0 is for a person");
  // Neither does one of a campaign that does not have it, or that says nothing of what it holds.
  InstallationPlanT without = on_sill(plan_after_setting(0, "without"));
  without.brackets[4]->measured.setConstant(nan), without.brackets[4]->basis.clear();
  without.panels[0]->sills.clear();
  next_plan(state, std::move(without));
  EXPECT_EQ(item(state, "p0").status, ItemStatus::planned);
  EXPECT_EQ(item(state, "p0").why, "waits for its sill: s0 is for a person");
  ASSERT_TRUE(accept_item(state, "s0"));
  next_plan(state, on_sill(plan_after_setting(0, "accepted"), 0.008));
  EXPECT_EQ(item(state, "p0").status, ItemStatus::released) << item(state, "p0").why;
}

TEST(Sills, AReportThatOneWasKnockedHoldsWhatItHolds) {
  for (const ItemStatus status :
       {ItemStatus::planned, ItemStatus::released, ItemStatus::executed, ItemStatus::verified}) {
    LoopStateT state = with_first_panel(status);
    EXPECT_TRUE(apply_actuals(state, knocked("s0")).empty());
    EXPECT_EQ(item(state, "s0").status, ItemStatus::rejected);
    EXPECT_EQ(item(state, "s0").why, "reported failed: plate knocked");
    EXPECT_EQ(item(state, "p0").status, status == ItemStatus::planned ? ItemStatus::planned : ItemStatus::rejected);
    EXPECT_EQ(apply_actuals(state, knocked("s0")).size(), 1u) << "once is enough";
    next_plan(state, on_sill(plan_after_setting(0, "later")));
    EXPECT_NE(item(state, "p0").why.find("s0"), std::string::npos) << item(state, "p0").why;
    EXPECT_NE(item(state, "p0").status, ItemStatus::released);
    EXPECT_NE(item(state, "p0").status, ItemStatus::verified);
  }
  LoopStateT state = with_first_panel(ItemStatus::released);
  ActualsT set = done({"s0"}, 0);
  ASSERT_EQ(apply_actuals(state, set).size(), 1u);
  EXPECT_NE(apply_actuals(state, set)[0].find("is a place of a sill"), std::string::npos)
      << apply_actuals(state, set)[0];
}

TEST(Sills, SayWhatTheyHold) {
  LoopStateT state = with_first_panel(ItemStatus::planned);
  next_plan(state, on_sill(plan_after_setting(0)));
  EXPECT_EQ(item(state, "s0").why, "holds the bottom edge of p0: nothing is to be set");
  const std::string words = next_words(state);
  EXPECT_NE(words.find("floor 1: s0, s1 hold the bottom edges of p0: nothing is to be set there\n"), std::string::npos)
      << words;
  EXPECT_NE(installation_words(on_sill(make_plan("first"))).find("Of the bottom edges that a sill holds (p0) the plan"),
            std::string::npos)
      << "its ends are not in it";
  EXPECT_EQ(settings_csv(on_sill(make_plan("first"))).find("s0"), std::string::npos) << "nobody sets it";
}

}  // namespace test_sills
}  // namespace plumbline::loop

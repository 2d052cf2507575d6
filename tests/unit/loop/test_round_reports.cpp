// What reports of a round may say: of another release, place, name or date they are not taken.
#include <gtest/gtest.h>

#include "geometry/random.hpp"
#include "hung_panel.hpp"
#include "loop/state/control_change.hpp"
#include "loop/state/gone_items.hpp"
#include "loop/state/next_words.hpp"
#include "loop/state/plan_artifact.hpp"
#include "random_facade.hpp"
#include "two_floors.hpp"

namespace plumbline::loop {
namespace test_round_reports {

using namespace test;

TEST(Rounds, APanelThatWasReportedDoneAndThenFailedGoesToAPerson) {
  for (const bool judged : {false, true}) {
    LoopStateT state = with_hung_panel();
    if (judged) next_plan(state, plan_after_setting(0, "third"));
    ActualsT failed = done({"p0"}, item(state, "p0").revision);
    failed.items[0]->outcome = "failed", failed.items[0]->note = "on the pallet";
    std::vector<std::string> doubted;
    EXPECT_TRUE(apply_actuals(state, failed, &doubted).empty());
    ASSERT_EQ(doubted.size(), 1u);
    EXPECT_NE(doubted[0].find("says failed, a report before it said done"), std::string::npos) << doubted[0];
    EXPECT_EQ(item(state, "p0").status, ItemStatus::rejected);
    EXPECT_EQ(item(state, "p0").why, "reported done, then failed, look whether it hangs: on the pallet");
    next_plan(state, plan_after_setting(0, "fourth"));
    EXPECT_EQ(item(state, "p0").status, ItemStatus::rejected);
    // That somebody looked does not say what was seen.
    close_round(state);
    EXPECT_NE(next_words(state).find("if it hangs as it should, run with reported.with.accept=['p0 hangs@1'], else "
                                     "with reported.with.removed=['p0@1']"),
              std::string::npos)
        << next_words(state);
    EXPECT_NE(accept_look(state, "p0@1").find("does not say whether it hangs"), std::string::npos);
    EXPECT_EQ(item(state, "p0").status, ItemStatus::rejected);
    LoopStateT down = state;
    EXPECT_EQ(accept_look(state, "p0 hangs@1"), "");
    EXPECT_EQ(item(state, "p0").status, ItemStatus::relocalised);
    EXPECT_NE(remove_look(down, "p0@0"), "");
    EXPECT_EQ(remove_look(down, "p0@1"), "");
    EXPECT_EQ(item(down, "p0").status, ItemStatus::planned);
    EXPECT_FALSE(item(down, "p0").hangs);
    EXPECT_NE(remove_look(down, "p0@1"), "");
  }
}

/// A file of yesterday's first attempt that comes after today's round.
TEST(Rounds, AFailureBeforeWhatWasDoneContradictsNothing) {
  LoopStateT state = with_released_panel();
  ActualsT hung = done({"p0"}, item(state, "p0").revision), failed = hung;
  hung.items[0]->at = "2026-05-05T06:00:00+02:00";
  failed.items[0]->outcome = "failed", failed.items[0]->at = "2026-05-05T03:00:00Z";
  EXPECT_TRUE(apply_actuals(state, hung).empty());
  next_plan(state, plan_after_setting(0, "third"));
  ASSERT_EQ(item(state, "p0").status, ItemStatus::verified);
  const auto refused = apply_actuals(state, failed);
  ASSERT_EQ(refused.size(), 1u);
  EXPECT_NE(refused[0].find("not after the item was released or reported last at 2026-05-05T06:00:00+02:00"),
            std::string::npos)
      << refused[0];
  EXPECT_EQ(item(state, "p0").status, ItemStatus::verified);
  failed.items[0]->at = "2026-05-05T05:00:00Z";
  EXPECT_TRUE(apply_actuals(state, failed).empty());
  EXPECT_EQ(item(state, "p0").status, ItemStatus::rejected);
}

/// Its report says that it hangs outside its limits: the plates alone do not verify it.
TEST(Rounds, APlaceWithoutSigmaThatIsOutsideTheLimitsGoesToAPerson) {
  const auto judged = [](double off, double sigma = 0) {
    LoopStateT state = with_released_panel();
    ActualsT actuals = done({"p0"}, item(state, "p0").revision);
    actuals.items[0]->measured = {off, 0.001, -0.002};
    if (sigma > 0) actuals.items[0]->sigma.setConstant(sigma);
    EXPECT_TRUE(apply_actuals(state, actuals).empty());
    EXPECT_TRUE(item(state, "p0").seen);
    InstallationPlanT plan = plan_after_setting(0, "third");
    for (auto& panel : plan.panels) panel->centre_sigma = {0.0005, 0.0005, 0.0005};
    for (const double limit : {0.005, 0.003}) {
      plan.lengths.push_back(std::make_unique<PlannedLengthT>());
      plan.lengths.back()->quantity = "corner", plan.lengths.back()->panels = {"p0"};
      plan.lengths.back()->low = -limit, plan.lengths.back()->high = limit;
    }
    next_plan(state, plan);
    return state;
  };
  // A tape or the tool of a robot that nobody calibrated.
  LoopStateT near = judged(0.004), coarse = judged(0.012), far = judged(0.040);
  EXPECT_EQ(item(near, "p0").status, ItemStatus::verified) << item(near, "p0").why;
  EXPECT_EQ(item(coarse, "p0").status, ItemStatus::verified) << item(coarse, "p0").why;
  EXPECT_EQ(item(far, "p0").status, ItemStatus::rejected);
  EXPECT_EQ(item(far, "p0").why.find("was reported 40.0 mm from where its brackets say that it hangs, more than its "
                                     "limits of 5.0 mm and the 20.0 mm that a place without sigma may be off by: look"),
            0u)
      << item(far, "p0").why;
  // Stating a sigma that it agrees by makes it no better than stating none, unless that explains it.
  LoopStateT stated = judged(0.040, 0.012), explained = judged(0.035, 0.012), at_eight = judged(0.026, 0.008);
  EXPECT_EQ(item(stated, "p0").status, ItemStatus::rejected);
  EXPECT_NE(
      item(stated, "p0").why.find("20.0 mm that a place may be off by, and more than three times its sigma: look"),
      std::string::npos)
      << item(stated, "p0").why;
  EXPECT_EQ(item(explained, "p0").status, ItemStatus::verified) << item(explained, "p0").why;
  EXPECT_EQ(item(at_eight, "p0").status, ItemStatus::rejected);
  LoopStateT within = judged(0.024, 0.012);
  EXPECT_EQ(item(within, "p0").status, ItemStatus::verified);
  EXPECT_TRUE(accept_item(far, "p0"));
  next_plan(far, plan_after_setting(0, "fourth"));
  EXPECT_EQ(item(far, "p0").status, ItemStatus::verified);
}

/// Measured to what is stated, a sound panel sends nobody more often than three sigmas on one of three axes do.
TEST(Rounds, AnHonestCoarseSigmaSendsFewSoundPanelsToAPerson) {
  for (const double sigma : {0.008, 0.010, 0.012}) {
    Random random(7);
    int sent = 0;
    for (int k = 0; k < 400; ++k) {
      LoopStateT state = with_released_panel();
      ActualsT actuals = done({"p0"}, item(state, "p0").revision);
      actuals.items[0]->measured = random.normal3(sigma);
      actuals.items[0]->sigma.setConstant(sigma);
      apply_actuals(state, actuals);
      InstallationPlanT plan = plan_after_setting(0, "third");
      for (auto& panel : plan.panels) panel->centre_sigma = {0.0005, 0.0005, 0.0005};
      plan.lengths.push_back(std::make_unique<PlannedLengthT>());
      plan.lengths.back()->quantity = "corner", plan.lengths.back()->panels = {"p0"};
      plan.lengths.back()->low = -0.005, plan.lengths.back()->high = 0.005;
      next_plan(state, plan);
      sent += item(state, "p0").status == ItemStatus::rejected ? 1 : 0;
    }
    EXPECT_LE(sent, 10) << sigma;  // 0.8 % are 3.2
  }
}

/// By a sigma of 50 mm it could hang anywhere: it is taken as done, and a person looks.
TEST(Rounds, APlaceOfACoarseSigmaShowsNotThatThePanelHangs) {
  LoopStateT state = with_released_panel();
  ActualsT actuals = done({"p0"}, item(state, "p0").revision);
  actuals.items[0]->measured = {0.03, 0.001, 0}, actuals.items[0]->sigma.setConstant(0.02);
  std::vector<std::string> doubted;
  EXPECT_TRUE(apply_actuals(state, actuals, &doubted).empty());
  ASSERT_EQ(doubted.size(), 1u);
  EXPECT_NE(doubted[0].find("it has a sigma of 20.0 mm, 12.5 mm at most show it; measure it again"), std::string::npos)
      << doubted[0];
  EXPECT_TRUE(item(state, "p0").hangs);
  EXPECT_FALSE(item(state, "p0").seen);
  next_plan(state, plan_after_setting(0, "third"));
  EXPECT_EQ(item(state, "p0").status, ItemStatus::relocalised) << item(state, "p0").why;
}

TEST(Rounds, APanelsPlaceThatIsItsTargetInMillimetresIsNoMeasurement) {
  LoopStateT state = with_released_panel();
  item(state, "p0").expected = {12.34567, 1.00032, 7.1};
  ActualsT actuals = done({"p0"}, item(state, "p0").revision);
  actuals.items[0]->measured = {12.346, 1.0, 7.1};
  EXPECT_TRUE(apply_actuals(state, actuals).empty());
  EXPECT_TRUE(item(state, "p0").hangs);
  EXPECT_FALSE(item(state, "p0").seen);
}

TEST(Rounds, AMeasurementThatBeganAfterItsPlanIsRefused) {
  LoopStateT state;
  MachineOptions options;
  options.at = "2026-05-02T10:00:00+02:00", options.measured_at = "2026-05-02T09:00:00Z";
  EXPECT_THROW(apply_plan(state, make_plan("first"), options), std::runtime_error);
  options.measured_at = "2026-05-02T08:00:00Z";
  EXPECT_NO_THROW(apply_plan(state, make_plan("first"), options));
}

TEST(Rounds, APanelReportFromTheNeighboursPlaceIsRefused) {
  LoopStateT state = with_released_panel();
  ActualsT actuals = done({"p0"}, item(state, "p0").revision);
  actuals.items[0]->measured = {1.5, 0, 0};
  EXPECT_EQ(apply_actuals(state, actuals).size(), 1u);
  EXPECT_EQ(item(state, "p0").status, ItemStatus::released);
  actuals.items[0]->measured = {0.01, 0, 0};
  EXPECT_TRUE(apply_actuals(state, actuals).empty());
}

TEST(Rounds, AReportOfAnotherJobOrWithoutAnyTieToItsReleaseIsRefused) {
  LoopStateT state = with_released_panel();
  item(state, "p0").jobs = {"job-2-abc", "job-2-F1-def"};
  ActualsT actuals = done({"p0"}, 0);
  auto refused = apply_actuals(state, actuals);
  ASSERT_EQ(refused.size(), 1u);
  EXPECT_NE(refused[0].find("has no revision, no job and no date"), std::string::npos) << refused[0];
  actuals.items[0]->revision = item(state, "p0").revision, actuals.items[0]->job = "job-2-F2-xyz";
  refused = apply_actuals(state, actuals);
  ASSERT_EQ(refused.size(), 1u);
  EXPECT_NE(refused[0].find("answers job-2-F2-xyz, the item was released with job-2-F1-def"), std::string::npos);
  actuals.items[0]->job = "job-2-abc";
  EXPECT_TRUE(apply_actuals(state, actuals).empty());
}

TEST(Rounds, AReportWithTheDateOfTheOneBeforeIsRefused) {
  LoopStateT state = with_released_panel();
  item(state, "p0").at = "2026-05-02T08:00:00Z";
  ActualsT actuals = done({"p0"}, item(state, "p0").revision);
  actuals.items[0]->at = "2026-05-02T10:00:00+02:00";
  EXPECT_EQ(apply_actuals(state, actuals).size(), 1u);
}

/// A rejected panel hangs until it is taken down: its brackets stay, and accepting it does not release it again.
TEST(Rounds, ARejectedPanelThatHangsStillHangs) {
  LoopStateT state = with_hung_panel();
  InstallationPlanT third = plan_after_setting(0, "third");
  third.brackets[0]->measured.x() += 0.006;
  next_plan(state, std::move(third));
  ASSERT_EQ(item(state, "p0").status, ItemStatus::rejected);
  Facade facade;
  facade.panels.resize(1), facade.panels[0].id = "p0", facade.panels[0].hooks = {{0}};
  facade.brackets.resize(1);
  apply_state(facade, state);
  EXPECT_TRUE(facade.panels[0].installed);
  EXPECT_TRUE(facade.brackets[0].fixed);
  EXPECT_TRUE(accept_item(state, "p0"));
  EXPECT_EQ(item(state, "p0").status, ItemStatus::relocalised);
}

/// By its new name it would be hung where it hangs.
TEST(Rounds, AnElementWithANewNameIsRefused) {
  const auto named = [](const std::string& basis, const std::string& bracket, const std::string& panel) {
    InstallationPlanT plan = make_plan(basis);
    plan.brackets[0]->guid = "guid-b0", plan.panels[0]->guid = "guid-p0";
    plan.brackets[0]->id = bracket, plan.panels[0]->id = panel, plan.panels[0]->brackets[0] = bracket;
    plan.panels[1]->depends_on = {panel};
    return plan;
  };
  LoopStateT state;
  next_plan(state, named("first", "b0", "p0"));
  for (const auto& [bracket, panel] : {std::pair{"b0", "p00"}, {"b00", "p0"}}) {
    try {
      next_plan(state, named("second", bracket, panel));
      FAIL();
    } catch (const std::runtime_error& error) {
      EXPECT_NE(
          std::string(error.what())
              .find(bracket == std::string("b0") ? "panel p00 was p0 (PLANNED)" : "bracket b00 was b0 (RELEASED)"),
          std::string::npos)
          << error.what();
    }
  }
  EXPECT_EQ(state.items.size(), 6u);
  // Two anchors on one element are no renaming.
  InstallationPlanT two = named("second", "b0", "p0");
  two.brackets.push_back(std::make_unique<BracketSettingT>(*two.brackets[0]));
  two.brackets.back()->id = "b9";
  EXPECT_NO_THROW(next_plan(state, two));
}

TEST(Rounds, ANameThatMeansAnotherElementIsRefused) {
  LoopStateT state;
  InstallationPlanT first = make_plan("first"), second = make_plan("second");
  first.brackets[0]->guid = "1aaa", second.brackets[0]->guid = "2bbb";
  next_plan(state, std::move(first));
  EXPECT_THROW(next_plan(state, std::move(second)), std::runtime_error);
}

}  // namespace test_round_reports
}  // namespace plumbline::loop

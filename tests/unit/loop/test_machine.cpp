// States of brackets and panels: nothing wrong becomes VERIFIED.
#include <gtest/gtest.h>

#include "loop/state/next_words.hpp"
#include "two_floors.hpp"

namespace plumbline::loop {
namespace test_machine {

using namespace test;

TEST(Machine, BracketsComeBeforeTheirPanelAndFloorsBeforeTheNext) {
  LoopStateT state;
  next_plan(state, make_plan("first"), {});
  EXPECT_EQ(state.revision, 1);
  EXPECT_EQ(item(state, "b0").status, ItemStatus::released);
  EXPECT_EQ(item(state, "p0").status, ItemStatus::planned);
  EXPECT_EQ(item(state, "b2").status, ItemStatus::planned);  // p0 does not hang yet
  EXPECT_TRUE(apply_actuals(state, done({"b0", "b1"}, 1)).empty());
  next_plan(state, plan_after_setting(0.0004), {});
  EXPECT_EQ(item(state, "b0").status, ItemStatus::verified);
  EXPECT_EQ(item(state, "p0").status, ItemStatus::released);
  EXPECT_TRUE(apply_actuals(state, done({"p0"}, item(state, "p0").revision)).empty());
  InstallationPlanT third = plan_after_setting(0.0004, "third");
  next_plan(state, third, {});
  EXPECT_EQ(item(state, "p0").status, ItemStatus::verified);
  EXPECT_EQ(item(state, "b2").status, ItemStatus::released);
  EXPECT_EQ(check_journal(state.journal).words, "");
}

TEST(Machine, WithoutANewMeasurementNothingIsVerified) {
  LoopStateT state;
  next_plan(state, make_plan("first"), {});
  apply_actuals(state, done({"b0", "b1"}, 1));
  next_plan(state, plan_after_setting(0, "first"), {});
  EXPECT_EQ(item(state, "b0").status, ItemStatus::executed);
}

TEST(Machine, ARobotThatReportsSuccessAndDidNothingIsFound) {
  LoopStateT state;
  next_plan(state, make_plan("first"), {});
  apply_actuals(state, done({"b0", "b1"}, 1));
  InstallationPlanT second = plan_after_setting(0);
  second.brackets[0]->measured.z() -= 0.004;  // where it was before
  next_plan(state, second, {});
  EXPECT_EQ(item(state, "b0").status, ItemStatus::rejected);
  EXPECT_EQ(item(state, "p0").status, ItemStatus::planned);
  EXPECT_TRUE(accept_item(state, "b0"));
  next_plan(state, make_plan("third"), {});
  EXPECT_EQ(item(state, "b0").status, ItemStatus::released) << item(state, "b0").why;
}

/// The word that accepted one hanging, left in the command, does not accept the next.
TEST(Machine, ALookIsAcceptedOnceAndByItsRound) {
  LoopStateT state;
  next_plan(state, make_plan("first"), {});
  apply_actuals(state, done({"b0", "b1"}, 1));
  InstallationPlanT second = plan_after_setting(0);
  second.brackets[0]->measured.z() -= 0.004;
  next_plan(state, second, {});
  close_round(state);
  ASSERT_EQ(item(state, "b0").status, ItemStatus::rejected);
  const std::string word = look_word(state, "b0");
  EXPECT_EQ(word, "b0@1");
  EXPECT_NE(next_step(state).find("reported.with.accept=['NAME@1']"), std::string::npos) << next_step(state);
  EXPECT_NE(accept_look(state, "b0").find("says no round: if somebody has looked after round 1, say 'b0@1'"),
            std::string::npos)
      << accept_look(state, "b0");
  EXPECT_NE(accept_look(state, "b7@1").find("'b7' is no rejected bracket"), std::string::npos);
  EXPECT_EQ(item(state, "b0").status, ItemStatus::rejected);
  EXPECT_EQ(accept_look(state, word), "");
  EXPECT_EQ(item(state, "b0").status, ItemStatus::planned);
  // Rejected again, and the word is still in the command.
  next_plan(state, make_plan("third"), {});
  apply_actuals(state, done({"b0"}, item(state, "b0").revision));
  InstallationPlanT fourth = make_plan("fourth");
  next_plan(state, fourth, {});
  close_round(state);
  ASSERT_EQ(item(state, "b0").status, ItemStatus::rejected);
  EXPECT_NE(accept_look(state, word).find("'b0@1' is of round 1, the state is after round 2"), std::string::npos)
      << accept_look(state, word);
  EXPECT_EQ(item(state, "b0").status, ItemStatus::rejected);
}

/// Brackets under a panel that would not hang right on them are set again, and again.
TEST(Machine, AtMostSoManyReworks) {
  LoopStateT state;
  MachineOptions options;
  options.most_reworks = 2;
  double moved = 0;
  for (int round = 0; round < 12; ++round) {
    InstallationPlanT plan = make_plan(std::to_string(round));
    for (int i : {0, 1}) {
      plan.brackets[i]->measured.z() += moved;
      plan.brackets[i]->setting = {0, 0.001, 0};
    }
    if (item_status(state, "b0") == ItemStatus::executed || item_status(state, "b0") == ItemStatus::verified)
      plan.panels[0]->gate = GateDecision::no_go, plan.panels[0]->p_in = 0.01;
    next_plan(state, plan, options);
    if (item_status(state, "b0") == ItemStatus::released) moved += 0.001;
    apply_actuals(state, done({"b0", "b1"}, item(state, "b0").revision));
  }
  EXPECT_EQ(item(state, "b0").status, ItemStatus::rejected) << item(state, "b0").why;
  EXPECT_EQ(item(state, "b0").reworks, 3);
  close_round(state);
  EXPECT_TRUE(state.done);
  EXPECT_EQ(state.given_up, 2);
}

/// Nobody has taken it down because a measurement says that it should be: it hangs, and its brackets with it.
TEST(Machine, AHangingPanelOutsideItsLimitsHangsUntilSomebodySaysThatItWasTakenDown) {
  LoopStateT state;
  next_plan(state, make_plan("first"), {});
  apply_actuals(state, done({"b0", "b1"}, 1));
  next_plan(state, plan_after_setting(0), {});
  apply_actuals(state, done({"p0"}, item(state, "p0").revision));
  InstallationPlanT third = plan_after_setting(0.002, "third");
  third.panels[0]->p_in = 0.01, third.panels[0]->gate = GateDecision::no_go;
  next_plan(state, third, {});
  EXPECT_EQ(item(state, "p0").status, ItemStatus::rework);
  EXPECT_TRUE(item(state, "p0").hangs);
  EXPECT_TRUE(item(state, "p0").seen);
  EXPECT_EQ(item(state, "p0").reworks, 1);
  for (const char* id : {"b0", "b1"}) {
    EXPECT_EQ(item(state, id).status, ItemStatus::verified);
    EXPECT_EQ(item(state, id).reworks, 0);
  }
  close_round(state);
  EXPECT_EQ(state.next, "take down what is named below, and run with reported.with.removed=['p0@1'] for each");
  EXPECT_NE(next_words(state).find("take down p0: hangs outside its limits: p 0.990"), std::string::npos)
      << next_words(state);
  InstallationPlanT same = plan_after_setting(0.002, "fourth");
  same.panels[0]->p_in = 0.01, same.panels[0]->gate = GateDecision::no_go;
  next_plan(state, same, {});
  EXPECT_EQ(item(state, "p0").status, ItemStatus::rework);
  EXPECT_EQ(item(state, "p0").reworks, 1);
  EXPECT_EQ(item(state, "b0").status, ItemStatus::verified);

  LoopStateT again = state;
  next_plan(again, plan_after_setting(0, "fifth"), {});  // its limits were widened, or the slab came back
  EXPECT_EQ(item(again, "p0").status, ItemStatus::verified);

  EXPECT_EQ(remove_look(state, "p0@1"), "");
  EXPECT_EQ(item(state, "p0").status, ItemStatus::planned);
  EXPECT_FALSE(item(state, "p0").hangs);
  same.basis = "sixth";
  next_plan(state, same, {});
  EXPECT_EQ(item(state, "b0").reworks, 1);
  EXPECT_EQ(item(state, "b0").status, ItemStatus::planned);
  EXPECT_EQ(check_journal(state.journal).words, "");
}

/// What was said to be done by mistake, or broke, is planned again; a word of before it was hung again is not taken.
TEST(Machine, APanelThatWasTakenDownIsReportedSo) {
  const auto removal = [](const std::string& at, int revision) {
    ActualsT actuals = done({"p0"}, revision);
    actuals.items[0]->outcome = "removed", actuals.items[0]->at = at, actuals.items[0]->by = "fitter";
    actuals.items[0]->note = "glass broken";
    return actuals;
  };
  LoopStateT state;
  next_plan(state, make_plan("first"), {});
  apply_actuals(state, done({"b0", "b1"}, 1));
  next_plan(state, plan_after_setting(0), {});
  const int revision = item(state, "p0").revision;
  EXPECT_NE(apply_actuals(state, removal("", revision)).at(0).find("by what was reported it does not hang"),
            std::string::npos);
  ActualsT hung = done({"p0"}, revision);
  hung.items[0]->at = "2026-05-05T06:00:00Z";
  EXPECT_TRUE(apply_actuals(state, hung).empty());
  next_plan(state, plan_after_setting(0, "third"), {});
  ASSERT_EQ(item(state, "p0").status, ItemStatus::verified);
  for (const ActualsT& wrong : {removal("", 0), removal("2026-05-05T05:00:00Z", 0), removal("", revision + 1),
                                removal("2026-05-05T05:00:00Z", revision)}) {
    EXPECT_EQ(apply_actuals(state, wrong).size(), 1u);
    EXPECT_EQ(item(state, "p0").status, ItemStatus::verified);
  }
  ActualsT bracket = done({"b0"}, 1);
  bracket.items[0]->outcome = "removed";
  EXPECT_NE(apply_actuals(state, bracket).at(0).find("is said of a panel"), std::string::npos);
  LoopStateT by_date = state;
  EXPECT_TRUE(apply_actuals(by_date, removal("2026-05-06T06:00:00Z", 0)).empty());
  EXPECT_TRUE(apply_actuals(state, removal("", revision)).empty());
  for (LoopStateT* one : {&state, &by_date}) {
    EXPECT_EQ(item(*one, "p0").status, ItemStatus::planned);
    EXPECT_FALSE(item(*one, "p0").hangs || item(*one, "p0").seen);
    EXPECT_NE(one->journal.back().find("reported removed: glass broken"), std::string::npos) << one->journal.back();
    next_plan(*one, plan_after_setting(0, "fourth"), {});
    EXPECT_EQ(item(*one, "p0").status, ItemStatus::released);
    EXPECT_EQ(item(*one, "p1").status, ItemStatus::planned);
    EXPECT_EQ(check_journal(one->journal).words, "");
  }
}

/// In whatever order the files come.
TEST(Machine, APanelThatWasHungAndTakenDownInOneRoundDoesNotHang) {
  LoopStateT state;
  next_plan(state, make_plan("first"), {});
  apply_actuals(state, done({"b0", "b1"}, 1));
  next_plan(state, plan_after_setting(0), {});
  ActualsT both = done({"p0", "p0"}, item(state, "p0").revision);
  both.items[0]->outcome = "removed", both.items[0]->at = "2026-05-05T09:00:00Z";
  both.items[1]->at = "2026-05-05T06:00:00Z";
  EXPECT_TRUE(apply_actuals(state, both).empty());
  EXPECT_EQ(item(state, "p0").status, ItemStatus::planned);
  EXPECT_FALSE(item(state, "p0").hangs);
}

TEST(Machine, ABracketThatMovedWithoutAReportIsFound) {
  LoopStateT state;
  next_plan(state, make_plan("first"), {});
  apply_actuals(state, done({"b0", "b1"}, 1));
  InstallationPlanT second = plan_after_setting(0);
  second.panels[0]->gate = GateDecision::go;
  next_plan(state, second, {});
  InstallationPlanT third = plan_after_setting(0, "third");
  third.brackets[0]->measured.x() += 0.005;
  next_plan(state, third, {});
  EXPECT_EQ(item(state, "b0").status, ItemStatus::rejected);
  EXPECT_NE(item(state, "b0").why.find("moved by 5.0 mm without a report that was taken"), std::string::npos);
  EXPECT_EQ(item(state, "b1").status, ItemStatus::verified);
}

TEST(Machine, ReportsThatAreWrongAreNamedAndChangeNothing) {
  LoopStateT state;
  next_plan(state, make_plan("first"), {});
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
  EXPECT_NE(refused[2].find("outcome 'perhaps', expected done, failed, skipped or removed"), std::string::npos);
  EXPECT_NE(refused[3].find("not after the item was released or reported last at 2026-05-02"), std::string::npos);
  EXPECT_NE(refused[4].find("the item is PLANNED, not RELEASED: nobody asked for it"), std::string::npos);
  EXPECT_NE(refused[5].find("m from where it should be"), std::string::npos);
  EXPECT_EQ(item(state, "b0").status, ItemStatus::released);
  EXPECT_EQ(item(state, "b1").status, ItemStatus::released);
}

/// The panel is done, and nothing has seen it hang: with the place that was given, and what is wrong with it.
TEST(Machine, APlaceThatDoesNotShowThatAPanelHangsIsTold) {
  for (const Eigen::Vector3d& off :
       {Eigen::Vector3d(0.12, 0, 0), Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(0.003, 0, 0)}) {
    LoopStateT state;
    next_plan(state, make_plan("first"), {});
    apply_actuals(state, done({"b0", "b1"}, 1));
    next_plan(state, plan_after_setting(0), {});
    ActualsT report = done({"p0"}, item(state, "p0").revision);
    report.items[0]->measured = item(state, "p0").expected + off;
    std::vector<std::string> doubted;
    EXPECT_TRUE(apply_actuals(state, report, &doubted).empty());
    EXPECT_EQ(item(state, "p0").status, ItemStatus::executed);
    const bool shows = off.x() == 0.003;
    EXPECT_EQ(item(state, "p0").seen, shows);
    ASSERT_EQ(doubted.size(), shows ? 0u : 1u);
    if (shows) continue;
    EXPECT_NE(doubted[0].find(off.x() > 0 ? "it lies 120 mm from where it should be, 50 mm along an axis show it"
                                          : "it is the number that was asked for"),
              std::string::npos)
        << doubted[0];
  }
}

TEST(Machine, AReportWhoseNameIsSpeltInAnotherWaySaysWhoseItWouldBe) {
  LoopStateT state;
  next_plan(state, make_plan("first"), {});
  const auto refused = apply_actuals(state, done({"B-00"}, 1));
  ASSERT_EQ(refused.size(), 1u);
  EXPECT_NE(refused[0].find("but for case, separators or leading zeros it is b0"), std::string::npos) << refused[0];
  EXPECT_EQ(item(state, "b0").status, ItemStatus::released);
}

TEST(Machine, TheSameReportTwiceChangesNothingMore) {
  LoopStateT state;
  next_plan(state, make_plan("first"), {});
  apply_actuals(state, done({"b0"}, 1));
  const auto journal = state.journal;
  EXPECT_EQ(apply_actuals(state, done({"b0"}, 1)),
            std::vector<std::string>{"report on b0 by robot-1: was reported before; nothing changes"});
  EXPECT_EQ(state.journal, journal);
}

TEST(Machine, ControlThatMovedMakesReleasedWorkStale) {
  LoopStateT state;
  next_plan(state, make_plan("first"), {});
  recall(state, {"CP3"}, "control point CP3 moved by 6.0 mm");
  EXPECT_EQ(item(state, "b0").status, ItemStatus::planned);
  EXPECT_EQ(state.moved_control, std::vector<std::string>{"CP3"});
  const auto refused = apply_actuals(state, done({"b0"}, 1));
  ASSERT_EQ(refused.size(), 1u);
  EXPECT_NE(refused[0].find("not RELEASED"), std::string::npos);
}

TEST(Machine, WhatAMeasurementCannotTellIsNoMove) {
  LoopStateT state;
  next_plan(state, make_plan("first"), {});
  InstallationPlanT second = make_plan("second");
  second.brackets[2]->measured.x() += 0.005;
  second.brackets[2]->sigma.setConstant(0.001);  // 5.7 mm are four standard deviations of a difference
  next_plan(state, second, {});
  EXPECT_EQ(item(state, "b2").status, ItemStatus::planned);
}

TEST(Machine, AFloorThatMovedAsAWholeIsNotJudged) {
  InstallationPlanT first = make_plan("first"), second = make_plan("second");
  for (InstallationPlanT* plan : {&first, &second})
    for (auto& bracket : plan->brackets) bracket->floor = 1;
  LoopStateT state;
  next_plan(state, first, {});
  for (auto& bracket : second.brackets) bracket->measured.z() += 0.006;
  next_plan(state, second, {});
  EXPECT_EQ(state.moved_control, std::vector<std::string>{"control of floor 1"});
  EXPECT_EQ(item(state, "b0").status, ItemStatus::planned);
  EXPECT_NE(item(state, "b0").why.find("moved together since they were measured last: check their control"),
            std::string::npos);
}

TEST(Machine, ANewAdjustmentWithAnotherResultMakesReleasedSettingsStale) {
  LoopStateT state;
  next_plan(state, make_plan("first"), {});
  InstallationPlanT second = make_plan("second");
  second.brackets[0]->setting.y() = 0.006;
  next_plan(state, second, {});
  EXPECT_EQ(item(state, "b0").revision, 2);
  EXPECT_EQ(item(state, "b1").revision, 1);
  EXPECT_NEAR(item(state, "b0").pending.y(), 0.006, 1e-12);
}

TEST(Machine, WhatWasVerifiedOnControlThatMovedIsInDoubtUntilItFitsAgain) {
  InstallationPlanT first = make_plan("first"), second = plan_after_setting(0), third = plan_after_setting(0, "third"),
                    fourth = plan_after_setting(0, "fourth");
  for (InstallationPlanT* plan : {&first, &second, &third, &fourth})
    for (auto& bracket : plan->brackets) bracket->floor = 1;
  LoopStateT state;
  next_plan(state, first, {});
  apply_actuals(state, done({"b0", "b1"}, 1));
  next_plan(state, second, {});
  ASSERT_EQ(item(state, "b0").status, ItemStatus::verified);
  for (auto& bracket : third.brackets) bracket->measured.z() += 0.006;
  next_plan(state, third, {});
  EXPECT_EQ(item(state, "b0").status, ItemStatus::relocalised);
  EXPECT_EQ(item(state, "p0").status, ItemStatus::planned);
  close_round(state);
  EXPECT_EQ(state.verified, 0);
  next_plan(state, fourth, {});
  EXPECT_EQ(item(state, "b0").status, ItemStatus::verified);
  EXPECT_TRUE(state.moved_control.empty());
}

TEST(Machine, ControlThatAPersonHasLookedAtIsTheReferenceFromThen) {
  InstallationPlanT first = make_plan("first"), second = make_plan("second"), third = make_plan("third");
  for (InstallationPlanT* plan : {&first, &second, &third})
    for (auto& bracket : plan->brackets) bracket->floor = 1;
  for (InstallationPlanT* plan : {&second, &third})
    for (auto& bracket : plan->brackets) bracket->measured.z() += 0.006;
  LoopStateT state;
  next_plan(state, first, {});
  apply_actuals(state, done({"b0", "b1"}, 1));
  for (int i : {0, 1}) second.brackets[i]->measured.x() += 0.004;  // something was done too
  next_plan(state, second, {});
  EXPECT_FALSE(state.moved_control.empty());
  EXPECT_TRUE(accept_item(state, "control of floor 1"));
  EXPECT_FALSE(accept_item(state, "control of floor 1"));
  InstallationPlanT fourth = third;
  next_plan(state, third, {});
  EXPECT_TRUE(state.moved_control.empty());
  // What was executed in between is planned anew, and verified by nothing that was measured before.
  EXPECT_EQ(item(state, "b0").status, ItemStatus::planned);
  fourth.basis = "fourth";
  next_plan(state, fourth);
  EXPECT_EQ(item(state, "b0").status, ItemStatus::released);
  EXPECT_EQ(item(state, "b0").reworks, 0);
}

TEST(Machine, ABracketThatWasNotMeasuredOnceIsStillJudgedByWhereItWasToBe) {
  LoopStateT state;
  next_plan(state, make_plan("first"), {});
  apply_actuals(state, done({"b0", "b1"}, 1));
  InstallationPlanT hidden = plan_after_setting(0, "hidden");
  hidden.brackets[0]->measured.setConstant(nan);
  next_plan(state, hidden, {});
  EXPECT_EQ(item(state, "b0").status, ItemStatus::executed);
  for (const char* basis : {"third", "fourth"}) {
    InstallationPlanT plan = plan_after_setting(0, basis);
    plan.brackets[0]->measured.x() += 0.008;
    next_plan(state, plan, {});
    EXPECT_EQ(item(state, "b0").status, ItemStatus::rejected) << item(state, "b0").why;
  }
}

/// Set right, and its plate knocked by 5 mm meanwhile: planned again it would be set wrong, and measured right.
TEST(Machine, APlateThatWasKnockedWhileItsBracketWasSetGoesToAPerson) {
  LoopStateT state;
  next_plan(state, make_plan("first"), {});
  apply_actuals(state, done({"b0", "b1"}, 1));
  InstallationPlanT second = plan_after_setting(0);
  second.brackets[0]->measured += Eigen::Vector3d(0.004, 0, 0.003);
  next_plan(state, second, {});
  EXPECT_EQ(item(state, "b0").status, ItemStatus::rejected);
  EXPECT_NE(item(state, "b0").why.find("look whether the bracket slipped or its plate was knocked"), std::string::npos);
  EXPECT_EQ(item(state, "b1").status, ItemStatus::verified);
}

/// A plate that was knocked while its bracket was set looks like that, too, if it was knocked by what was asked for.
TEST(Machine, AKnownMistakeOfARobotIsNamedToWhoLooks) {
  const auto after = [](double moved) {
    LoopStateT state;
    InstallationPlanT first = make_plan("first");
    for (int i : {0, 1}) first.brackets[i]->setting = {0, 0.004, 0.005};
    next_plan(state, first, {});
    apply_actuals(state, done({"b0", "b1"}, 1));
    InstallationPlanT second = make_plan("second");
    second.brackets[0]->measured += moved * Eigen::Vector3d(0, -0.005, 0.004);
    second.brackets[1]->measured += Eigen::Vector3d(0, -0.005, 0.004);
    second.panels[0]->gate = GateDecision::hold;
    next_plan(state, second, {});
    // What was done is what counts for its range.
    EXPECT_NEAR(item(state, "b0").setting.z(), moved * 0.005, 1e-9);
    EXPECT_EQ(item(state, "b0").status, ItemStatus::rejected);
    return item(state, "b0").why;
  };
  EXPECT_NE(after(0).find("as if it was not moved: look whether that is so, or its plate was knocked"),
            std::string::npos)
      << after(0);
  EXPECT_NE(after(-1).find("it was set the other way"), std::string::npos) << after(-1);
  EXPECT_NE(after(2).find("it was set twice"), std::string::npos) << after(2);
}

TEST(Machine, WhatWasSkippedRecalledOrMadeStaleIsWhereItWas) {
  for (const char* how : {"skipped", "recalled", "stale"}) {
    LoopStateT state;
    next_plan(state, make_plan("first"), {});
    ActualsT skipped = done({"b0"}, 1);
    skipped.items[0]->outcome = "skipped";
    if (how == std::string("skipped")) {
      EXPECT_TRUE(apply_actuals(state, skipped).empty());
    }
    if (how == std::string("recalled")) recall(state, {"CP3"}, "moved"), accept_item(state, "CP3");
    InstallationPlanT second = make_plan("second");
    second.panels[0]->gate = GateDecision::hold;
    second.brackets[0]->setting.y() = 0.006;
    next_plan(state, second, {});
    next_plan(state, make_plan("third"), {});
    EXPECT_EQ(item(state, "b0").status, ItemStatus::released) << how << ": " << item(state, "b0").why;
  }
}

TEST(Machine, SmallMovementsOfWhatIsVerifiedAddUp) {
  LoopStateT state;
  next_plan(state, make_plan("first"), {});
  apply_actuals(state, done({"b0", "b1"}, 1));
  for (int i = 0; i < 4; ++i) {
    InstallationPlanT plan = plan_after_setting(0, std::to_string(i));
    plan.brackets[0]->measured.x() += 0.002 * i;
    next_plan(state, plan, {});
  }
  EXPECT_EQ(item(state, "b0").status, ItemStatus::rejected);
}

}  // namespace test_machine
}  // namespace plumbline::loop

// What a plan may and may not conclude: from old measurements, from brackets that nobody sets, of panels that hang.
#include <gtest/gtest.h>

#include "hung_panel.hpp"
#include "loop/state/control_change.hpp"
#include "loop/state/gone_items.hpp"
#include "loop/state/next_words.hpp"
#include "loop/state/plan_artifact.hpp"
#include "random_facade.hpp"
#include "two_floors.hpp"

namespace plumbline::loop {
namespace test_rounds {

using namespace test;

TEST(Rounds, ABracketThatThisPlanRejectsCarriesNoPanel) {
  LoopStateT state;
  next_plan(state, make_plan("first"));
  apply_actuals(state, done({"b0", "b1"}, 1));
  InstallationPlanT second = plan_after_setting(0), third = plan_after_setting(0, "third");
  second.brackets[1]->measured.setConstant(nan), second.brackets[1]->basis.clear();
  next_plan(state, std::move(second));
  ASSERT_EQ(item(state, "b0").status, ItemStatus::verified);
  third.brackets[0]->measured.x() += 0.006;
  next_plan(state, std::move(third));
  EXPECT_EQ(item(state, "b0").status, ItemStatus::rejected);
  EXPECT_EQ(item(state, "b1").status, ItemStatus::verified);
  EXPECT_EQ(item(state, "p0").status, ItemStatus::planned) << item(state, "p0").why;
}

/// Work that nobody will ever do is not shown as waiting.
TEST(Rounds, ABracketThatNoPanelHangsOnIsToldSo) {
  LoopStateT state;
  InstallationPlanT plan = make_plan("first");
  for (const auto& bracket : plan.brackets) bracket->use = BracketUse::panel;
  for (const auto& [id, use] : {std::pair{"k0", BracketUse::nothing}, {"k1", BracketUse::not_planned}}) {
    plan.brackets.push_back(std::make_unique<BracketSettingT>(*plan.brackets[0]));
    plan.brackets.back()->id = id, plan.brackets.back()->use = use;
  }
  InstallationPlanT later = plan;
  next_plan(state, plan);
  EXPECT_EQ(item(state, "k0").status, ItemStatus::planned);
  EXPECT_EQ(item(state, "k0").why, "no panel hangs on it: nothing is to be set");
  EXPECT_EQ(item(state, "k1").why, "the panel on it is not planned: installation.txt says why");
  EXPECT_EQ(item(state, "b2").why, "");
  const std::string words = next_words(state);
  EXPECT_NE(words.find("floor 1: no panel hangs on k0: nothing is to be set there\n"), std::string::npos) << words;
  EXPECT_NE(words.find("floor 1: the panels on k1 are not planned"), std::string::npos) << words;
  later.basis = "second", later.brackets.back()->use = BracketUse::panel;
  next_plan(state, later);
  EXPECT_EQ(item(state, "k1").why, "") << "its panel is planned now";
}

/// Once, however often it is measured: who was told of it finds in the journal that it was so.
TEST(Rounds, APanelThatTurnsNoGoIsInTheJournal) {
  LoopStateT state;
  const auto lines = [&] {
    return std::count_if(state.journal.begin(), state.journal.end(), [](const std::string& line) {
      return line.find("may not be hung so: ") != std::string::npos;
    });
  };
  for (const char* basis : {"first", "second"}) {
    InstallationPlanT plan = make_plan(basis);
    plan.panels[0]->gate = GateDecision::no_go, plan.panels[0]->reason = std::string("p 0.010 of ") + basis;
    next_plan(state, std::move(plan));
    EXPECT_EQ(lines(), 1) << basis;
    EXPECT_EQ(item(state, "p0").why, std::string("p 0.010 of ") + basis);
  }
  InstallationPlanT by_hand = make_plan("third");
  by_hand.relaxations = {"re-drill b2"};
  by_hand.panels[1]->gate = GateDecision::hold, by_hand.panels[1]->reason = "p 0.500; set it by hand";
  by_hand.panels[1]->by_hand = {0};
  next_plan(state, std::move(by_hand));
  EXPECT_EQ(lines(), 2);
}

/// A tower of which the lower half was measured is not at its end.
TEST(Rounds, WhatNobodyMeasuredIsWorkThatIsLeft) {
  const auto plan = [](const std::string& basis, double off) {
    InstallationPlanT made = basis == "first" ? make_plan(basis) : plan_after_setting(off, basis);
    made.panels.pop_back();
    add_unplanned(made, "p1", "guid-p1", 2, Eigen::Vector3d::Zero(), "not one anchor there was measured: measure them");
    return made;
  };
  LoopStateT state;
  next_plan(state, plan("first", 0));
  EXPECT_EQ(item(state, "p1").reason, ItemReason::not_planned);
  apply_actuals(state, done({"b0", "b1"}, 1));
  next_plan(state, plan("second", 0));
  EXPECT_EQ(next_step(state), "give the job to the robots, then measure and run again");
  apply_actuals(state, done({"p0"}, item(state, "p0").revision));
  next_plan(state, plan("third", 0));
  close_round(state);
  ASSERT_EQ(item(state, "p0").status, ItemStatus::verified) << item(state, "p0").why;
  EXPECT_TRUE(state.done) << "nothing is left without a person";
  EXPECT_EQ(state.next, "measure the anchors of the panels below that are not planned, then run again");
  const std::string words = next_words(state);
  EXPECT_EQ(words.rfind("1 of 2 panels hang", 0), 0u) << words;
  EXPECT_NE(words.find("floor 2: p1 is not planned: not one anchor there was measured: measure them\n"),
            std::string::npos)
      << words;
  // Measured, it is a panel as any other.
  next_plan(state, plan_after_setting(0, "fourth"));
  EXPECT_NE(item(state, "p1").reason, ItemReason::not_planned);
  EXPECT_EQ(item(state, "b2").status, ItemStatus::released);
}

TEST(Rounds, ABracketThatIsToBeSetAgainIsPlannedFirstAndTheLoopIsNotDone) {
  LoopStateT state;
  next_plan(state, make_plan("first"));
  apply_actuals(state, done({"b0", "b1"}, 1));
  InstallationPlanT second = plan_after_setting(0);
  second.panels[0]->gate = GateDecision::no_go, second.panels[0]->p_in = 0.01;  // on brackets as they stand now
  next_plan(state, std::move(second));
  EXPECT_EQ(item(state, "b0").status, ItemStatus::planned) << item(state, "b0").why;
  EXPECT_EQ(item(state, "p0").status, ItemStatus::planned);
  close_round(state);
  EXPECT_FALSE(state.done);
  InstallationPlanT third = plan_after_setting(0, "second");  // the same measurement
  third.brackets[0]->setting.y() = 0.004;
  next_plan(state, std::move(third));
  EXPECT_EQ(item(state, "b0").status, ItemStatus::released);
}

/// More likely inside than not, and sure to be if campaigns had no errors of their own: measured, not set again.
TEST(Rounds, WhatAnotherCampaignMayDecideIsMeasuredAgainAndNotSetAgain) {
  for (const auto& [p, repeated, measured] : {std::tuple{0.8, 0.99, true}, {0.4, 0.99, false}, {0.8, 0.955, false}}) {
    LoopStateT state;
    next_plan(state, make_plan("first"));
    apply_actuals(state, done({"b0", "b1"}, 1));
    InstallationPlanT second = plan_after_setting(0);
    second.panels[0]->gate = GateDecision::hold, second.panels[0]->p_in = p;
    second.panels[0]->p_in_repeated = repeated;
    next_plan(state, std::move(second));
    close_round(state);
    EXPECT_EQ(item(state, "b0").status, measured ? ItemStatus::verified : ItemStatus::planned) << p << " " << repeated;
    EXPECT_EQ(state.to_measure, measured);
    EXPECT_FALSE(state.done);
    if (!measured) continue;
    EXPECT_NE(item(state, "p0").why.find("waits for another campaign"), std::string::npos) << item(state, "p0").why;
    next_plan(state, plan_after_setting(0, "third"));
    EXPECT_EQ(item(state, "p0").status, ItemStatus::released);
    EXPECT_FALSE(state.to_measure);
  }
}

/// Where campaigns are not combined each says the same again: after ten of them a person decides.
TEST(Rounds, MeasuringOnceMoreHasAnEnd) {
  LoopStateT state;
  next_plan(state, make_plan("first"));
  apply_actuals(state, done({"b0", "b1"}, 1));
  for (int round = 0; round < 12; ++round) {
    InstallationPlanT plan = plan_after_setting(0, "round " + std::to_string(round));
    plan.panels[0]->gate = GateDecision::hold, plan.panels[0]->p_in = 0.8, plan.panels[0]->p_in_repeated = 0.99;
    next_plan(state, std::move(plan));
    close_round(state);
    EXPECT_EQ(state.to_measure, round < 10) << round;
    EXPECT_EQ(item(state, "p0").status, round < 10 ? ItemStatus::planned : ItemStatus::rejected) << round;
  }
  EXPECT_EQ(item(state, "p0").why.rfind("waited for 10 campaigns more, and none decided it", 0), 0u)
      << item(state, "p0").why;
  EXPECT_EQ(item(state, "b0").status, ItemStatus::verified);
  ASSERT_TRUE(accept_item(state, "p0"));
  next_plan(state, plan_after_setting(0, "more precise"));
  EXPECT_EQ(item(state, "p0").status, ItemStatus::released);
}

/// A robot set it 16 mm down instead of 4 mm up. Somebody looks, and the plate is in order: what it can still be set by
/// is told by where it is, not by what was asked for.
TEST(Rounds, WhatABracketHasLeftAfterALookIsWhatIsMeasured) {
  Facade facade = random_facade({1, 1}, 4);
  facade.brackets.resize(1), facade.panels.clear(), facade.joints.clear();
  Bracket& bracket = facade.brackets[0];
  bracket.id = "b0", bracket.design.setZero(), bracket.deviation = {0, 0, -0.020};
  bracket.axes << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  LoopStateT state;
  next_plan(state, make_plan("first"));
  apply_actuals(state, done({"b0", "b1"}, 1));
  InstallationPlanT second = plan_after_setting(0);
  second.brackets[0]->measured.z() = -0.020;
  next_plan(state, std::move(second));
  ASSERT_EQ(item(state, "b0").status, ItemStatus::rejected);
  ASSERT_TRUE(accept_item(state, "b0"));
  Facade planned = facade;
  apply_state(planned, state);
  EXPECT_NEAR(planned.brackets[0].type.high.y(), 0.015 + 0.016, 1e-9);
  EXPECT_NEAR(planned.brackets[0].type.low.y(), 0, 1e-9);
  InstallationPlanT third = plan_after_setting(0, "third");
  third.brackets[0]->measured.z() = -0.020, third.brackets[0]->setting.y() = 0.020;
  next_plan(state, std::move(third));
  EXPECT_NEAR(item(state, "b0").setting.y(), -0.016, 1e-9);
  EXPECT_EQ(item(state, "b0").status, ItemStatus::released);
  // Control that was found in order elsewhere says nothing of that any more.
  recall(state, {"control of floor 1"}, "moved");
  accept_item(state, "control of floor 1");
  EXPECT_TRUE(item(state, "b0").unset.empty());
}

TEST(Rounds, WhatWasReportedAsSetIsPlannedAsItStands) {
  Facade facade = random_facade({1, 1}, 4);
  LoopStateT state;
  for (const ItemStatus status : {ItemStatus::executed, ItemStatus::relocalised, ItemStatus::planned}) {
    auto item = std::make_unique<LoopItemT>();
    item->id = facade.brackets[state.items.size()].id, item->kind = "bracket", item->status = status;
    item->setting.setZero();
    state.items.push_back(std::move(item));
  }
  apply_state(facade, state);
  EXPECT_TRUE(facade.brackets[0].fixed);
  EXPECT_TRUE(facade.brackets[1].fixed);
  EXPECT_FALSE(facade.brackets[2].fixed);
}

TEST(Rounds, APanelThatIsNoLongerGoOrIsToHangElsewhereIsRecalled) {
  for (const bool elsewhere : {false, true}) {
    LoopStateT state = with_released_panel();
    ASSERT_EQ(item(state, "p0").status, ItemStatus::released);
    const int revision = item(state, "p0").revision;
    InstallationPlanT third = plan_after_setting(0, "third");
    if (elsewhere)
      third.panels[0]->shift.z() = 0.002;
    else
      third.panels[0]->gate = GateDecision::no_go, third.panels[0]->p_in = 0.01;
    next_plan(state, std::move(third));
    EXPECT_EQ(item(state, "p0").status, elsewhere ? ItemStatus::released : ItemStatus::planned);
    EXPECT_EQ(item(state, "p0").revision > revision, elsewhere);
    EXPECT_EQ(apply_actuals(state, done({"p0"}, revision)).size(), 1u);
  }
}

TEST(Rounds, ACampaignOnAnotherFloorVerifiesNothingHere) {
  LoopStateT state;
  next_plan(state, make_plan("first"));
  apply_actuals(state, done({"b0", "b1"}, 1));
  InstallationPlanT second = plan_after_setting(0);
  for (std::size_t i : {0u, 1u}) second.brackets[i]->basis = "<first>";
  next_plan(state, std::move(second));
  EXPECT_EQ(item(state, "b0").status, ItemStatus::executed);
  EXPECT_EQ(item(state, "p0").status, ItemStatus::planned);
  next_plan(state, plan_after_setting(0, "third"));
  EXPECT_EQ(item(state, "b0").status, ItemStatus::verified);
}

TEST(Rounds, TheBasisOfAnAnchorIsItsOwnMeasurement) {
  Facade facade = random_facade({2, 1}, 4);
  const auto bases = [](const Facade& f) {
    const Fit fit = plan_settings(f);
    std::vector<std::string> out;
    for (const auto& bracket : plan_artifact(f, fit, judge_plan(f, fit)).brackets) out.push_back(bracket->basis);
    return out;
  };
  const auto before = bases(facade);
  Facade other = facade;
  other.brackets.back().deviation.z() += 0.001;                                     // measured again up there
  other.brackets[0].design.x() += 0.002, other.brackets[0].deviation.x() -= 0.002;  // the design was revised
  const auto after = bases(other);
  EXPECT_EQ(after[0], before[0]);
  EXPECT_NE(after.back(), before.back());
}

TEST(Rounds, APanelIsVerifiedByAnchorsThatWereAllMeasuredSinceItHangs) {
  LoopStateT state = with_hung_panel();
  InstallationPlanT hidden = plan_after_setting(0, "hidden"), old = plan_after_setting(0, "old");
  hidden.brackets[0]->measured.setConstant(nan), hidden.brackets[0]->basis.clear();
  hidden.panels[0]->gate = GateDecision::hold;
  next_plan(state, std::move(hidden));
  EXPECT_EQ(item(state, "p0").status, ItemStatus::executed);
  old.brackets[0]->basis = "<second>";  // measured before the panel was hung
  next_plan(state, std::move(old));
  EXPECT_EQ(item(state, "p0").status, ItemStatus::executed);
  next_plan(state, plan_after_setting(0, "third"));
  EXPECT_EQ(item(state, "p0").status, ItemStatus::verified);
}

TEST(Rounds, APanelThatNothingHasSeenIsNotVerified) {
  const auto report = [](const Eigen::Vector3d& measured) {
    LoopStateT state = with_released_panel();
    ActualsT actuals = done({"p0"}, item(state, "p0").revision);
    actuals.items[0]->measured = measured;
    apply_actuals(state, actuals);
    next_plan(state, plan_after_setting(0, "third"));
    return state;
  };
  EXPECT_EQ(report({0.001, 0, 0}).journal.empty(), false);
  LoopStateT seen = report({0.001, 0.002, 0}), unsaid = report({nan, nan, nan}), echo = report({0, 0, 0}),
             elsewhere = report({0.2, 0, 0}), rounded = report({0, 0.00005, 0});
  EXPECT_EQ(item(seen, "p0").status, ItemStatus::verified);
  for (LoopStateT* state : {&unsaid, &echo, &elsewhere, &rounded}) {
    EXPECT_EQ(item(*state, "p0").status, ItemStatus::relocalised) << item(*state, "p0").why;
    EXPECT_EQ(item(*state, "b2").status, ItemStatus::planned);  // nor does the next floor begin
    close_round(*state);
    EXPECT_TRUE(state->done);
  }
  // A person has seen one, a total station the other, before the release of which nothing counts.
  EXPECT_TRUE(accept_item(unsaid, "p0"));
  EXPECT_FALSE(accept_item(unsaid, "p0"));
  // A file that does not say when may be of the time before it was taken down and hung again.
  ActualsT staked = done({"p0"}, 0);
  const auto refused = apply_actuals(echo, staked);
  ASSERT_EQ(refused.size(), 1u);
  EXPECT_NE(refused[0].find("has no revision, no job and no date"), std::string::npos) << refused[0];
  EXPECT_FALSE(item(echo, "p0").seen);
  staked.items[0]->at = "2026-05-04T08:00:00Z";
  EXPECT_TRUE(apply_actuals(echo, staked).empty());
  for (LoopStateT* state : {&unsaid, &echo}) {
    EXPECT_EQ(check_journal(state->journal).words, "");
    next_plan(*state, plan_after_setting(0, "fourth"));
    EXPECT_EQ(item(*state, "p0").status, ItemStatus::verified) << item(*state, "p0").why;
  }
}

/// Its plates are where they were to be, as far as any campaign on them tells.
TEST(Rounds, APanelThatHangsElsewhereThanItsBracketsSayGoesToAPerson) {
  const auto judged = [](double off, double sigma) {
    LoopStateT state = with_released_panel();
    ActualsT actuals = done({"p0"}, item(state, "p0").revision);
    actuals.items[0]->measured = {0.0003, 0, off}, actuals.items[0]->sigma.setConstant(sigma);
    EXPECT_TRUE(apply_actuals(state, actuals).empty());
    InstallationPlanT plan = plan_after_setting(0, "third");
    plan.panels[0]->centre_sigma = {0.0006, 0.0006, 0.0006};
    next_plan(state, std::move(plan));
    return state;
  };
  LoopStateT knocked = judged(0.0045, 0.0008), right = judged(0.0035, 0.0008), unsaid = judged(0.0045, nan);
  EXPECT_EQ(item(knocked, "p0").status, ItemStatus::rejected);
  EXPECT_EQ(item(knocked, "p0").why.find("was measured 4.5 mm from where its brackets say that it hangs: look whether"),
            0u)
      << item(knocked, "p0").why;
  EXPECT_EQ(item(right, "p0").status, ItemStatus::verified);
  EXPECT_NEAR(item(right, "p0").told_from, 0.00484, 1e-5);
  EXPECT_NE(next_words(right).find("of 1 verified panels would, from a shift of 4.8 mm at their centre on"),
            std::string::npos)
      << next_words(right);
  EXPECT_EQ(item(unsaid, "p0").status, ItemStatus::verified);
  EXPECT_NE(next_words(unsaid).find("of 1 verified panels nothing would"), std::string::npos) << next_words(unsaid);
  // Compared once, and not again after somebody has looked; the building sinks afterwards.
  EXPECT_TRUE(accept_item(knocked, "p0"));
  for (LoopStateT* state : {&knocked, &right}) {
    next_plan(*state, plan_after_setting(0, "fourth"));
    EXPECT_EQ(item(*state, "p0").status, ItemStatus::verified) << item(*state, "p0").why;
  }
  EXPECT_EQ(check_journal(knocked.journal).words, "");
}

/// A scaffold before one bracket is no reason to set the other one again.
TEST(Rounds, WhatWasNotMeasuredUndoesNothing) {
  LoopStateT state;
  next_plan(state, make_plan("first"));
  apply_actuals(state, done({"b0", "b1"}, 1));
  InstallationPlanT second = plan_after_setting(0);
  second.panels[0]->gate = GateDecision::hold, second.panels[0]->reason = "p 0.900";
  second.panels[0]->measure = "b1", second.panels[0]->obstacle = PanelObstacle::none;
  LoopStateT undone = state;
  next_plan(undone, second);
  EXPECT_EQ(item(undone, "b0").reworks, 1) << "what the control of this test says of a panel that is HOLD by numbers";
  InstallationPlanT part = plan_after_setting(0);
  part.brackets[1]->measured.setConstant(nan), part.brackets[1]->basis.clear();
  part.panels[0]->gate = GateDecision::hold, part.panels[0]->obstacle = PanelObstacle::not_measured;
  part.panels[0]->reason = "not measured: b1; measure it, then plan again; p 1.000";
  next_plan(state, part);
  EXPECT_EQ(item(state, "b0").status, ItemStatus::verified) << item(state, "b0").why;
  EXPECT_EQ(item(state, "b0").reworks, 0);
}

/// "1 of 6 panels hang" of a design that has five.
TEST(Rounds, WhatLeftTheDesignIsNoWorkAndIsTakenDown) {
  LoopStateT state;
  const auto with_guids = [](InstallationPlanT plan) {
    for (const auto& panel : plan.panels) panel->guid = "guid-" + panel->id;
    return plan;
  };
  next_plan(state, with_guids(make_plan("first")));
  apply_actuals(state, done({"b0", "b1"}, 1));
  next_plan(state, with_guids(plan_after_setting(0)));
  LoopStateT released = state;
  apply_actuals(state, done({"p0"}, item(state, "p0").revision));
  const auto without = [&](const std::string& basis) {
    InstallationPlanT plan = with_guids(plan_after_setting(0, basis));
    plan.panels.erase(plan.panels.begin());
    plan.panels[0]->depends_on.clear(), plan.panels[0]->gate = GateDecision::hold;
    plan.gone = {"guid-p0"};
    return plan;
  };
  for (LoopStateT* one : {&state, &released}) next_plan(*one, without("third")), close_round(*one);
  EXPECT_EQ(item(released, "p0").status, ItemStatus::planned);
  EXPECT_EQ(next_words(released).find("0 of 1 panels hang"), 0u) << next_words(released);
  EXPECT_EQ(next_words(state).find("0 of 1 panels hang"), 0u) << next_words(state);
  EXPECT_NE(
      next_words(state).find("floor 1: look whether p0 is to be taken down: the design does not have it any more; "
                             "when it is down, run with reported.with.removed=['p0@1']"),
      std::string::npos)
      << next_words(state);
  EXPECT_EQ(remove_look(state, "p0@1"), "");
  EXPECT_EQ(next_words(state).find("taken down"), std::string::npos);
}

/// The IFC of one floor alone ordered to take down all that hangs on the others.
TEST(Rounds, ADesignOfOneFloorIsNoRevisionWithoutTheOthers) {
  LoopStateT state;
  for (int i = 0; i < 6; ++i) {
    state.items.push_back(std::make_unique<LoopItemT>());
    LoopItemT& one = *state.items.back();
    one.id = "p" + std::to_string(i), one.guid = "guid-" + one.id, one.kind = "panel", one.floor = 1 + i / 3;
  }
  const auto gone = [&](const std::vector<int>& there) {
    DesignT design;
    for (const int i : there) {
      design.elements.push_back(std::make_unique<DesignElementT>());
      design.elements.back()->guid = "guid-p" + std::to_string(i);
    }
    return gone_items(design, {}, state);
  };
  const GoneItems floor = gone({3, 4, 5}), facade = gone({0, 3}), revised = gone({0, 1, 3, 4, 5});
  EXPECT_TRUE(floor.guids.empty());
  EXPECT_EQ(floor.missing.find("p0, p1, p2 are not in this design, nor is most of the same storey"), 0u);
  EXPECT_TRUE(facade.guids.empty());
  EXPECT_EQ(revised.guids, std::vector<std::string>{"guid-p2"});
  EXPECT_EQ(revised.missing, "");
  state.items[2]->gone = true;
  EXPECT_EQ(gone({3, 4, 5}).guids, std::vector<std::string>{"guid-p2"}) << "it left before";
}

TEST(Rounds, WhatWasMeasuredBeforeTheWorkJudgesNothing) {
  const auto after = [](const std::string& reported, const std::string& measured) {
    LoopStateT state;
    MachineOptions options;
    options.at = "2026-05-02T08:00:00Z";
    next_plan(state, make_plan("first"), options);
    ActualsT actuals = done({"b0", "b1"}, 1);
    for (auto& actual : actuals.items) actual->at = reported;
    EXPECT_TRUE(apply_actuals(state, actuals).empty());
    // Read after the work, and nobody had moved anything yet: neither floor nor bracket moved, nothing is verified.
    InstallationPlanT second = measured > "2026-05-02T10" ? plan_after_setting(0) : make_plan("second");
    options.measured_at = measured, options.at = "2026-05-03T08:00:00Z";
    next_plan(state, std::move(second), options);
    EXPECT_TRUE(state.moved_control.empty());
    return std::string(name_of(item(state, "b0").status)) + " " + item(state, "b0").why;
  };
  EXPECT_EQ(after("2026-05-02T10:00:00Z", "2026-05-02T13:00:00+02:00").substr(0, 8), "VERIFIED");
  EXPECT_EQ(after("2026-05-02T10:00:00Z", "2026-05-02T09:30:00Z"),
            "EXECUTED waits for a measurement that was made after it was done");
  EXPECT_EQ(after("", "2026-05-02T12:00:00Z"),
            "EXECUTED waits for a measurement that was made after it was done; its report has no date");
}

TEST(Rounds, AMeasurementThatContradictsItselfDecidesNothing) {
  LoopStateT state = with_hung_panel();
  InstallationPlanT third = plan_after_setting(0, "third");
  third.doubts = {"K3 does not fit by 12 mm"};
  third.brackets[0]->measured.x() += 0.006;
  third.panels[0]->gate = GateDecision::no_go, third.panels[0]->p_in = 0;
  next_plan(state, std::move(third));
  EXPECT_EQ(item(state, "p0").status, ItemStatus::executed);
  EXPECT_EQ(item(state, "p0").why, "the measurement is in doubt: K3 does not fit by 12 mm");
  EXPECT_EQ(item(state, "b0").status, ItemStatus::verified);
  EXPECT_EQ(item(state, "b0").reworks, 0);
}

TEST(Rounds, AVerifiedPanelThatIsNoLongerSureIsSo) {
  LoopStateT state = with_hung_panel();
  next_plan(state, plan_after_setting(0, "third"));
  ASSERT_EQ(item(state, "p0").status, ItemStatus::verified);
  InstallationPlanT fourth = plan_after_setting(0, "fourth");
  fourth.panels[0]->p_in = 0.6, fourth.panels[0]->gate = GateDecision::hold, fourth.panels[0]->reason = "p 0.600";
  next_plan(state, std::move(fourth));
  EXPECT_EQ(item(state, "p0").status, ItemStatus::relocalised);
  EXPECT_NE(item(state, "p0").why.find("no longer sure to hang right: p 0.600"), std::string::npos);
}

/// Set right by 4 mm each, and the control sank by as much: they seem not to have moved.
TEST(Rounds, BracketsThatShareAMistakeAreAFloorInDoubt) {
  LoopStateT state;
  next_plan(state, make_plan("first"));
  apply_actuals(state, done({"b0", "b1"}, 1));
  next_plan(state, make_plan("second"));
  EXPECT_EQ(state.moved_control, std::vector<std::string>{"control of floor 1"});
  EXPECT_EQ(item(state, "b0").reworks, 0);
  EXPECT_EQ(item(state, "b0").status, ItemStatus::executed);
  // Two anchors do not show that it is in order again.
  next_plan(state, plan_after_setting(0, "third"));
  EXPECT_EQ(state.moved_control, std::vector<std::string>{"control of floor 1"});
  EXPECT_EQ(item(state, "b0").status, ItemStatus::executed);
}

TEST(Rounds, WhatABracketHasUsedOfItsRangeIsWhatWasMeasured) {
  LoopStateT state;
  next_plan(state, make_plan("first"));
  ActualsT actuals = done({"b0", "b1"}, 1);
  actuals.items[0]->setting = {0, 0.009, 0};  // says the robot
  EXPECT_TRUE(apply_actuals(state, actuals).empty());
  next_plan(state, plan_after_setting(0.001));
  ASSERT_EQ(item(state, "b0").status, ItemStatus::verified);
  EXPECT_NEAR(item(state, "b0").setting.y(), 0.005, 1e-9);
}

}  // namespace test_rounds
}  // namespace plumbline::loop

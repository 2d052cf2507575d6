// Reports that are wrong change nothing, and are refused in words; what to do next is said.
#include <gtest/gtest.h>

#include <functional>

#include "geometry/random.hpp"
#include "loop/state/next_words.hpp"
#include "loop/state/place_doubts.hpp"
#include "loop/state/setting_scatter.hpp"
#include "two_floors.hpp"

namespace plumbline::loop {
namespace test_reports {

using namespace test;

TEST(NextWords, SaysHowFarItIsAndWhatComesNext) {
  LoopStateT state;
  next_plan(state, make_plan("first"), {});
  close_round(state);
  EXPECT_NE(next_words(state).find("0 of 2 panels hang and are verified, after round 1; 2 items are released"),
            std::string::npos)
      << next_words(state);
  EXPECT_NE(next_words(state).find("next: give the job to the robots, then measure and run again\n"),
            std::string::npos);
  EXPECT_NE(next_words(state).find("floor 1: set b0, b1\n"), std::string::npos);
  EXPECT_NE(next_words(state).find("floor 1: p0 waits for its brackets\n"), std::string::npos) << next_words(state);
  EXPECT_EQ(next_step(state), "give the job to the robots, then measure and run again");
  apply_actuals(state, done({"b0", "b1"}, 1));
  EXPECT_NE(next_words(state).find("next: measure, then run again\n"), std::string::npos);
  InstallationPlanT second = plan_after_setting(0);
  second.panels[0]->gate = GateDecision::hold, second.panels[0]->reason = "p 0.900; measuring b0 once more would do";
  second.panels[0]->measure = "b0", second.panels[1]->gate = GateDecision::hold;
  MachineOptions options;
  options.most_reworks = 0;
  next_plan(state, second, options);
  EXPECT_NE(next_words(state).find("floor 1: p0 waits: p 0.900; measuring b0 once more would do\n"), std::string::npos)
      << next_words(state);
  EXPECT_NE(next_words(state).find("next: somebody looks at what is named below"), std::string::npos)
      << next_words(state);
}

/// Of three files nobody would find the line by the item alone.
TEST(Reports, WhatIsRefusedSaysWhereItWasRead) {
  LoopStateT state;
  next_plan(state, make_plan("first"), {});
  ActualsT actuals = done({"b0", "b9"}, 1);
  actuals.items[1]->source = "a.json items[4]";
  EXPECT_EQ(apply_actuals(state, actuals)[0].find("report on b9 by robot-1 (a.json items[4]): no bracket or panel"),
            0u);
  actuals.items[1]->by = "staked.csv", actuals.items[1]->source = "staked.csv:7";
  EXPECT_EQ(apply_actuals(state, actuals)[1].find("report on b9 (staked.csv:7): no bracket or panel"), 0u);
  note_refused(state, {"report on b9 (staked.csv:7): no bracket or panel of this name is known"});
  EXPECT_EQ(next_words(state).find("not taken"), std::string::npos) << "the round is not over";
  note_refused(state, {"a.json: items[15]: has no 'item'"});
  EXPECT_EQ(state.refused[1]->report, "a.json: items[15]");
  EXPECT_EQ(state.refused[1]->why, "has no 'item'");
  close_round(state);
  EXPECT_NE(next_words(state).find("not taken: report on b9 (staked.csv:7): no bracket or panel"), std::string::npos);
  close_round(state);
  EXPECT_EQ(next_words(state).find("not taken"), std::string::npos) << "of the round before";
}

std::string refusal(const std::function<void(LoopStateT&, ActualT&)>& change, const std::string& now = {}) {
  LoopStateT state;
  MachineOptions options;
  options.at = "2026-05-02T08:00:00+02:00";
  InstallationPlanT plan = make_plan("first");
  for (auto& bracket : plan.brackets) bracket->measured += Eigen::Vector3d(50, 20, 30);
  next_plan(state, plan, options);
  ActualsT actuals = done({"b0"}, 1);
  change(state, *actuals.items[0]);
  const LoopStateT before = state;
  const auto refused = apply_actuals(state, actuals, nullptr, now);
  if (!refused.empty()) {
    EXPECT_EQ(state.journal, before.journal);
    EXPECT_EQ(item(state, "b0").status, ItemStatus::released);
    EXPECT_TRUE(item(state, "b0").setting.isZero());
  }
  return refused.empty() ? "taken" : refused[0];
}

TEST(Machine, PlacesInFeetOtherFramesOrWithAxesExchangedAreRefusedInWords) {
  const auto placed = [](const std::function<Eigen::Vector3d(const Eigen::Vector3d&)>& read) {
    return refusal([&](LoopStateT& state, ActualT& actual) { actual.measured = read(item(state, "b0").expected); });
  };
  using Place = Eigen::Vector3d;
  EXPECT_EQ(placed([](const Place& p) { return p; }), "taken");
  EXPECT_NE(placed([](const Place& p) { return Place(p / 0.3048); }).find("in feet"), std::string::npos);
  EXPECT_NE(placed([](const Place& p) { return Place(1e3 * p); }).find("in millimetres"), std::string::npos);
  EXPECT_NE(placed([](const Place& p) { return Place(p.y(), p.x(), p.z()); }).find("first two axes are exchanged"),
            std::string::npos);
  EXPECT_NE(placed([](const Place& p) { return Place(p + Place(400, 7, 0)); }).find("in another frame"),
            std::string::npos);
}

TEST(Machine, AReportFromBeforeTheReleaseIsRefusedWhateverItsZone) {
  const auto dated = [](const std::string& at) {
    return refusal([&](LoopStateT&, ActualT& actual) { actual.at = at; });
  };
  EXPECT_EQ(dated("2026-05-02T07:30:00Z"), "taken");
  EXPECT_EQ(dated("2026-05-01T23:00:01.5-0730"), "taken");
  EXPECT_NE(dated("2026-05-02T07:59:59+02:00").find("not after the item was released"), std::string::npos);
  EXPECT_NE(dated("2026-05-02T09:30:00+04:00").find("not after the item was released"), std::string::npos);
  EXPECT_NE(dated("02.05.2026 9:00").find("expected ISO 8601 with a zone"), std::string::npos);
  EXPECT_NE(dated("2026-05-02T09:00:00").find("expected ISO 8601 with a zone"), std::string::npos);
}

/// No campaign would be later than such work, and the report that mends it would come second.
TEST(Machine, AReportOfTomorrowIsRefusedWhateverItsZone) {
  const auto dated = [](const std::string& at) {
    return refusal([&](LoopStateT&, ActualT& actual) { actual.at = at; }, "2026-05-03T16:00:00+02:00");
  };
  EXPECT_EQ(dated("2026-05-03T14:00:00Z"), "taken");
  EXPECT_EQ(dated("2026-05-03T17:30:00+04:00"), "taken");
  const std::string words = dated("2026-05-03T14:00:01Z");
  EXPECT_NE(words.find("report on b0 by robot-1: is dated 2026-05-03T14:00:01Z, later than this round"),
            std::string::npos)
      << words;
  EXPECT_NE(dated("2062-05-03T08:00:00Z").find("later than this round"), std::string::npos);
}

TEST(Machine, ARoundIsNotBeforeWhatItReportsOn) {
  LoopStateT state;
  MachineOptions options;
  options.at = "2026-05-02T08:00:00+02:00";
  next_plan(state, make_plan("first"), options);
  EXPECT_EQ(time_doubt(state, ""), "");
  EXPECT_EQ(time_doubt(state, "2026-05-02T06:00:00Z"), "");
  EXPECT_NE(time_doubt(state, "2026-05-02T05:59:00Z").find("b0 was released at 2026-05-02T08:00:00+02:00, after it"),
            std::string::npos)
      << time_doubt(state, "2026-05-02T05:59:00Z");
}

/// A panel's place that is stated a thousand times too poor agrees with every bracket.
TEST(Machine, StandardDeviationsThatAreInAnotherUnitOrNoneAreRefused) {
  const auto stated = [](const Eigen::Vector3d& sigma) {
    return refusal([&](LoopStateT&, ActualT& actual) { actual.sigma = sigma; });
  };
  EXPECT_EQ(stated({0.001, 0.0005, 0.02}), "taken");
  const std::string words = stated({1.0, 1.0, 0.5});
  EXPECT_NE(words.find("report on b0 by robot-1: has a sigma of 1 m"), std::string::npos) << words;
  EXPECT_NE(words.find("that would fit if it is in millimetres"), std::string::npos) << words;
  EXPECT_NE(stated({0.0004, 0.3, 0.0004}).find("has a sigma of 0.3 m, by which it could be anywhere; give"),
            std::string::npos);
  EXPECT_NE(stated({1e-6, 1e-6, 4e-6}).find("if it is a variance"), std::string::npos);
  EXPECT_NE(stated({0.001, 0, 0.001}).find("expected three standard deviations in metres, each above 0"),
            std::string::npos);
  EXPECT_NE(stated({0.001, nan, 0.001}).find("expected three standard deviations"), std::string::npos);
}

/// Nor does it show afterwards that a panel hangs.
TEST(Machine, APlaceWithSuchAStandardDeviationShowsNoPanel) {
  for (const bool is_late : {false, true}) {
    LoopStateT state;
    next_plan(state, make_plan("first"));
    LoopItemT& panel = item(state, "p0");
    panel.status = ItemStatus::relocalised, panel.hangs = true, panel.revision = 1, panel.expected.setZero();
    ActualsT actuals = done({"p0"}, 1);
    actuals.items[0]->at = is_late ? "2027-05-02T08:00:00Z" : "2026-05-02T08:00:00Z";
    actuals.items[0]->sigma.setConstant(is_late ? 0.001 : 1.0);
    EXPECT_EQ(apply_actuals(state, actuals, nullptr, "2026-05-03T08:00:00Z").size(), 1U);
    EXPECT_FALSE(item(state, "p0").seen);
    EXPECT_TRUE(item(state, "p0").place.empty());
  }
}

TEST(Machine, ASettingInMillimetresIsRefused) {
  const auto set = [](const Eigen::Vector3d& setting) {
    return refusal([&](LoopStateT&, ActualT& actual) { actual.setting = setting; });
  };
  EXPECT_EQ(set({0, 0.0045, 0}), "taken");
  EXPECT_NE(set({0, 4, 0}).find("that would fit if it is in millimetres"), std::string::npos);
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

/// All hang and are verified, and the last measurement contradicts itself: that is not "nothing".
TEST(NextWords, ADoubtfulMeasurementIsToBeMended) {
  LoopStateT state;
  next_plan(state, make_plan("first"));
  for (auto& i : state.items) i->status = ItemStatus::verified, i->hangs = i->seen = i->kind == "panel";
  close_round(state);
  ASSERT_EQ(next_step(state), "nothing: every panel hangs within its limits");
  InstallationPlanT plan = make_plan("second");
  plan.doubts = {"readings contradict control"};
  next_plan(state, std::move(plan));
  close_round(state);
  EXPECT_EQ(next_step(state),
            "mend the measurement, it decides nothing: readings contradict control; then measure and run again");
  EXPECT_NE(next_words(state).find("the measurement is in doubt: readings contradict control\n"), std::string::npos);
  next_plan(state, make_plan("third"));
  close_round(state);
  EXPECT_EQ(next_step(state), "nothing: every panel hangs within its limits");
}

/// Forty brackets that were to be moved by 4 mm and stand `sigma` from there, in a frame of their own, each measured
/// with 0.3 mm between two campaigns.
std::pair<LoopStateT, InstallationPlanT> set_to(double sigma) {
  LoopStateT state;
  InstallationPlanT plan;
  Random random(5, "set");
  for (int i = 0; i < 40; ++i) {
    auto bracket = std::make_unique<BracketSettingT>();
    auto item = std::make_unique<LoopItemT>();
    item->id = bracket->id = "b" + std::to_string(i), item->kind = "bracket", item->status = ItemStatus::executed;
    bracket->basis = "<second>", item->basis = "<first>";
    bracket->axes = {Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitZ(), -Eigen::Vector3d::UnitY()};
    item->expected = {2.0 * i, 0, 0}, item->pending = {0, 0.004, 0};
    bracket->sigma.setConstant(0.0004), bracket->difference_sigma.setConstant(0.0003);
    bracket->measured = item->expected + Eigen::Vector3d(0, 0, 0.004) + random.normal3(sigma) + random.normal3(0.0003);
    state.items.push_back(std::move(item)), plan.brackets.push_back(std::move(bracket));
  }
  plan.setting_sigma = 0.0003, plan.station_sigma = 0;
  return {std::move(state), std::move(plan)};
}

TEST(SettingScatter, FindsHowWellBracketsAreSetAndTellsWhereThePlanTookLess) {
  for (const double sigma : {0.0003, 0.001}) {
    auto [state, plan] = set_to(sigma);
    plan.brackets[3]->measured.x() += 0.008, plan.brackets[4]->measured.z() -= 0.008;  // slipped, and wrongly set
    const SettingScatter scatter = setting_scatter(state, plan, "");
    EXPECT_EQ(scatter.brackets, 40);
    // A median of 120 lengths knows their scatter to 11 %, and what the campaigns differ by is taken out of it.
    EXPECT_NEAR(scatter.setting(), sigma, 3 * 0.11 * (sigma * sigma + 0.0003 * 0.0003) / sigma);
    EXPECT_EQ(scatter_words(scatter, plan).empty(), sigma < 0.0005);
    plan.setting_sigma = sigma;
    EXPECT_TRUE(scatter_words(scatter, plan).empty()) << scatter_words(scatter, plan).front();
  }
}

TEST(SettingScatter, WhatWasNotMeasuredSinceOrIsNotReportedTellsNothing) {
  auto [state, plan] = set_to(0.001);
  for (auto& bracket : plan.brackets) bracket->basis = "<first>";
  EXPECT_EQ(setting_scatter(state, plan, "").brackets, 0);
  for (auto& bracket : plan.brackets) bracket->basis = "<second>";
  for (auto& item : state.items) item->status = ItemStatus::released;
  EXPECT_EQ(setting_scatter(state, plan, "").brackets, 0);
  for (std::size_t i = 0; i < 5; ++i) state.items[i]->status = ItemStatus::executed;
  const SettingScatter five = setting_scatter(state, plan, "");
  EXPECT_EQ(five.brackets, 5);
  EXPECT_TRUE(scatter_words(five, plan).empty());  // too few to say so
}

/// A robot whose station is 2 mm off on one of four floors sets as well there as elsewhere.
TEST(SettingScatter, AStationThatIsOffAsAWholeIsNotHowItSets) {
  auto [state, plan] = set_to(0.0005);
  plan.setting_sigma = 0.0005, plan.station_sigma = 0.0002;
  for (std::size_t i = 0; i < 40; ++i) {
    state.items[i]->floor = 1 + static_cast<int>(i) / 10, state.items[i]->by = "R" + std::to_string(i / 20);
    if (state.items[i]->floor == 3) plan.brackets[i]->measured += Eigen::Vector3d(0.002, 0, -0.0002);
  }
  plan.brackets[3]->measured.x() += 0.008;  // slipped
  const SettingScatter scatter = setting_scatter(state, plan, "");
  EXPECT_NEAR(scatter.setting(), 0.0005, 0.00012);
  ASSERT_EQ(scatter.stations.size(), 4U);
  EXPECT_NEAR(scatter.stations[2].shift.x(), 0.002, 0.0006);
  EXPECT_NEAR(scatter.station(), 0.002 / std::sqrt(12.0), 0.0002) << "one of four stations, one of three directions";
  const auto words = scatter_words(scatter, plan);
  ASSERT_EQ(words.size(), 1U) << "nothing is said of how brackets are set";
  EXPECT_NE(words[0].find("what R1 set on floor 3 (10 brackets) stands off as a whole"), std::string::npos) << words[0];
  // All floors by as much: the same station each time, and still not how it sets.
  for (std::size_t i = 0; i < 40; ++i)
    if (state.items[i]->floor != 3) plan.brackets[i]->measured += Eigen::Vector3d(0.002, 0, -0.0002);
  EXPECT_NEAR(setting_scatter(state, plan, "").setting(), 0.0005, 0.00012);
  EXPECT_EQ(scatter_words(setting_scatter(state, plan, ""), plan).size(), 4U);
  // Two brackets of each: nothing parts the station from the setting, and what is seen is both.
  for (std::size_t i = 0; i < 40; ++i) {
    if (i % 10 > 1) state.items[i]->status = ItemStatus::released;
    if (state.items[i]->floor != 3) plan.brackets[i]->measured -= Eigen::Vector3d(0.002, 0, -0.0002);
  }
  EXPECT_TRUE(setting_scatter(state, plan, "").stations.empty());
}

}  // namespace test_reports
}  // namespace plumbline::loop

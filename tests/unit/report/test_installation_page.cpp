// The first line of the loop's page: it is green only if nothing is left to look at.
#include <gtest/gtest.h>

#include "show/report/installation_page.hpp"
#include "show/report/sections.hpp"

namespace plumbline::report {
namespace test_installation_page {

std::string next_of(const InstallationPlanT& plan, const LoopStateT& state) {
  return render_page("Loop", [&](Markup& html) { write_next(html, plan, state, {}); });
}

LoopStateT with_verified_panel() {
  LoopStateT state;
  state.items.push_back(std::make_unique<LoopItemT>());
  LoopItemT& panel = *state.items.back();
  panel.id = "p0", panel.kind = "panel", panel.floor = 1, panel.status = ItemStatus::verified;
  panel.hangs = panel.seen = true;
  state.next = "nothing: every panel hangs within its limits";
  return state;
}

bool is_green(const std::string& page) { return page.find("class=\"verdict pass\"") != std::string::npos; }

TEST(InstallationPage, IsGreenOnlyIfNobodyIsToLookAtAnything) {
  EXPECT_TRUE(is_green(next_of({}, with_verified_panel())));
  LoopStateT moved = with_verified_panel(), bracket = with_verified_panel();
  moved.moved_control = {"CP3"};
  EXPECT_FALSE(is_green(next_of({}, moved)));
  bracket.items.push_back(std::make_unique<LoopItemT>());
  bracket.items.back()->id = "b0", bracket.items.back()->kind = "bracket";
  bracket.items.back()->status = ItemStatus::rejected;
  EXPECT_FALSE(is_green(next_of({}, bracket)));
}

TEST(InstallationPage, ADoubtfulMeasurementStandsBeforeWhatItSays) {
  InstallationPlanT plan;
  plan.doubts = {"the image block: group tags contradicts the rest"};
  const std::string page = next_of(plan, with_verified_panel());
  EXPECT_FALSE(is_green(page));
  EXPECT_NE(page.find("Mend the measurement, it decides nothing: the image block"), std::string::npos);
  EXPECT_EQ(page.find("Next: nothing"), std::string::npos);
}

/// "Do what the lines below ask for" needs the lines.
TEST(InstallationPage, WhatAPanelWaitsForStandsOnTheFirstScreen) {
  LoopStateT state = with_verified_panel();
  const auto add = [&](const std::string& id, const std::string& why, ItemReason reason = ItemReason::other) {
    state.items.push_back(std::make_unique<LoopItemT>());
    LoopItemT& item = *state.items.back();
    item.id = id, item.kind = "panel", item.why = why, item.reason = reason;
  };
  add("p1", "waits for its brackets", ItemReason::waits_for_brackets);
  add("p2", "waits for p1, which is to hang before it", ItemReason::waits_for_panel);
  EXPECT_EQ(next_of({}, state).find("What waits, and for what"), std::string::npos);
  add("p3", "not measured: b7; measure it, then plan again");
  const std::string page = next_of({}, state);
  EXPECT_NE(page.find("What waits, and for what"), std::string::npos);
  EXPECT_NE(page.find("p3: not measured: b7; measure it, then plan again"), std::string::npos) << page;
  EXPECT_EQ(page.find("p2: waits"), std::string::npos);
}

std::string rest_of(const InstallationPlanT& plan, const LoopStateT& state) {
  return render_page("Loop", [&](Markup& html) {
    write_refused(html, state), write_rounds(html, plan, state), write_items(html, plan, state);
  });
}

std::size_t occurrences(const std::string& text, const std::string& what) {
  std::size_t n = 0;
  for (auto at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++n;
  return n;
}

/// Check anchors beside the facade are no work that waits.
TEST(InstallationPage, ABracketThatNoPanelHangsOnIsNotPlanned) {
  InstallationPlanT plan;
  LoopStateT state = with_verified_panel();
  for (const auto& [id, use] : {std::pair{"b0", BracketUse::panel}, {"k0", BracketUse::nothing}}) {
    plan.brackets.push_back(std::make_unique<BracketSettingT>());
    BracketSettingT& bracket = *plan.brackets.back();
    bracket.id = id, bracket.use = use, bracket.design.setZero(), bracket.measured.setZero(), bracket.sigma.setZero();
    bracket.axes = {Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitZ(), -Eigen::Vector3d::UnitY()};
    state.items.push_back(std::make_unique<LoopItemT>());
    state.items.back()->id = id, state.items.back()->kind = "bracket", state.items.back()->setting.setZero();
  }
  std::string page = rest_of(plan, state);
  EXPECT_EQ(idle_brackets(plan, state), std::set<std::string>{"k0"});
  EXPECT_EQ(occurrences(page, "NOT NEEDED"), 1u) << page;
  EXPECT_NE(page.find("Not counted: 1 on which no panel hangs. Nothing is to be set there: k0."), std::string::npos);
  EXPECT_EQ(states_by_round(state, {}, "bracket", {"k0"})[0].at("PLANNED"), 1);
  plan.brackets[1]->use = BracketUse::not_planned;
  EXPECT_EQ(occurrences(rest_of(plan, state), "NOT NEEDED"), 0u) << "its panel is to be planned still";
}

/// Without brackets on which nothing hangs, which nobody sets, and those of which the floor is not known.
TEST(InstallationPage, TheDriftThatTheLoopPreventedIsANumber) {
  InstallationPlanT plan;
  LoopStateT state;
  const auto add = [&](const std::string& id, int floor, double up, double set, BracketUse use) {
    plan.brackets.push_back(std::make_unique<BracketSettingT>());
    BracketSettingT& bracket = *plan.brackets.back();
    bracket.id = id, bracket.floor = floor, bracket.use = use, bracket.design.setZero(), bracket.sigma.setZero();
    bracket.measured = {0, 0, up};
    bracket.axes = {Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitZ(), -Eigen::Vector3d::UnitY()};
    state.items.push_back(std::make_unique<LoopItemT>());
    state.items.back()->id = id, state.items.back()->kind = "bracket", state.items.back()->setting = {0, set, 0};
  };
  add("b0", 1, 0.0002, 0.001, BracketUse::panel), add("k0", 1, 0.5, 0, BracketUse::nothing);
  add("b1", 12, 0.0005, 0.0034, BracketUse::panel), add("b2", 0, 0.25, 0, BracketUse::panel);
  const std::string page = rest_of(plan, state);
  EXPECT_NE(page.find("From floor 1 to floor 12 the mean height drifts by +0.3 mm; without what was set it would by "),
            std::string::npos)
      << page;
  EXPECT_NE(page.find(" mm: the drift that closing the loop prevented is "), std::string::npos) << page;
  EXPECT_EQ(page.substr(0, page.find("id=\"items\"")).find("500.0"), std::string::npos) << "k0 is no part of it";
}

/// Who reads the page does not read the terminal.
TEST(InstallationPage, ReportsThatWereNotTakenStandOnIt) {
  LoopStateT state = with_verified_panel();
  EXPECT_EQ(rest_of({}, state).find("Reports that were not taken"), std::string::npos);
  for (const int round : {1, 2}) {
    state.refused.push_back(std::make_unique<RefusedReportT>());
    state.refused.back()->round = round, state.refused.back()->report = "staked.csv:7, round " + std::to_string(round);
    state.refused.back()->why = "the coordinates of 'b2' are no numbers";
  }
  state.round = 2;
  const std::string page = rest_of({}, state);
  EXPECT_LT(page.find("staked.csv:7, round 2"), page.find("staked.csv:7, round 1")) << "the last first";
  EXPECT_NE(next_of({}, state).find("1\u00A0report was not taken in this round"), std::string::npos)
      << next_of({}, state);
}

TEST(InstallationPage, WhatIsToBeTakenDownStandsOnTheFirstScreen) {
  LoopStateT state = with_verified_panel();
  state.items[0]->status = ItemStatus::rework, state.items[0]->why = "hangs outside its limits: p 0.002";
  const std::string page = next_of({}, state);
  EXPECT_NE(page.find("take down p0: hangs outside its limits: p 0.002"), std::string::npos) << page;
  EXPECT_NE(page.find("class=\"verdict fail\""), std::string::npos);
  EXPECT_NE(page.find("1\u00A0item waits"), std::string::npos);
  state = with_verified_panel();
  state.items[0]->gone = true;
  EXPECT_NE(next_of({}, state).find("look whether p0 is to be taken down: the design does not have it any more"),
            std::string::npos);
  EXPECT_FALSE(is_green(next_of({}, state)));
}

TEST(InstallationPage, WhoeverIsToSeeAPanelHangIsCounted) {
  LoopStateT state = with_verified_panel();
  state.items[0]->status = ItemStatus::relocalised, state.items[0]->seen = false;
  EXPECT_NE(next_of({}, state).find("1\u00A0item waits"), std::string::npos);
}

}  // namespace test_installation_page
}  // namespace plumbline::report
